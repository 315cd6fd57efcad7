"""Words on the bars of an error budget can be read."""

from __future__ import annotations

from orchestrator.report.charts.diagnosis import budget_chart

NAMES = {"white": "#ffffff"}


def brightness(color: str) -> float:
    """Return the relative luminance of WCAG 2."""
    color = NAMES.get(color, color)
    parts = [int(color[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_the_words_stand_out() -> None:
    bars = budget_chart(1.0, 1.0, 1.0, named=True).figure.data
    assert len(bars) == 3
    for bar in bars:
        light, dark = sorted((brightness(bar.marker.color), brightness(bar.textfont.color)), reverse=True)
        assert (light + 0.05) / (dark + 0.05) > 3.5, bar.name
