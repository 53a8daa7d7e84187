"""Values and axes in the units of either system, as text shows them."""

import re

METRIC = re.compile(
    r"\d (?:mm|cm|m|N|N\*m|N·m|Pa)(?![\w/^*²³·])"
    r"|(?<![\w/·*])(?:m/s|km|kg|hPa|kPa|degC|°C)(?!\w)"
)
CUSTOMARY = re.compile(
    r"\d (?:in\.?|mi)(?=$|[,;.)])|(?<![\w/·*])(?:ft|lb|lbf|slug|inHg|inH2O|psi|degF|°F|mph)(?!\w)"
)
