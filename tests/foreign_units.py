"""Values in the units of either system, as text shows them."""

import re

METRIC = re.compile(
    r"\d (?:m/s|m/s\^2|m/s²|mm|cm|m|km|kg"
    r"|kg/m\^3|kg/m³|kg\*m\^2|kg·m²|N|N\*m|N·m|hPa|kPa|Pa|degC|°C)"
    r"(?![\w/^*²³·])"
)
CUSTOMARY = re.compile(
    r"\d (?:ft/s|ft/s\^2|ft/s²|ft|mi|lb|lbf|lbf/ft\^2|lbf/ft²|lbf\*ft|lbf·ft|slug"
    r"|slug/ft\^3|slug/ft³"
    r"|slug\*ft\^2|slug·ft²|inHg|inH2O|psi|degF|°F|mph)(?![\w/^*²³·])"
)
