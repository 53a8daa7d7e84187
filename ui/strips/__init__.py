"""Strip charts: many channels over one time axis, live and scrolled back.

    chart = StripChart()                    # looks at the history itself, 60 times a second
    chart.set_history(history)              # gsapp.session.sample_history.SampleHistory
    chart.set_layout(default_layout(history.channels))
    chart.navigator.go_to(120.0)
    chart.mark_requested.connect(marks.add)

`pixel_columns` lays bins over the absolute sample index; `raster` paints them into a ring of
pixels; `chart_raster` keeps the ring up with the history; `axis_ticks` chooses axes;
`chart_geometry` places everything in pixels of the screen. `chart_model` holds what is shown;
`chart_interaction` changes it by key, menu and mouse; `chart_canvas` keeps the picture and paints
it with `chart_painter`; `strip_chart` is the widget.
"""
