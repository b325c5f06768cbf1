"""Numbers as a reader wants them: few digits, powers of ten as powers, nothing that is not a number."""

from __future__ import annotations

import math
import re

from markupsafe import Markup, escape

NOTHING = Markup('<span class="nil">–</span>')


def number(value: float | None, digits: int = 3) -> Markup:
    """A number with `digits` significant digits; large and small ones as a product with a power of ten."""
    if value is None or not math.isfinite(value):
        return NOTHING
    if value == 0:
        return Markup("0")
    if value == int(value) and abs(value) < 1e5:  # a count, or a number that happens to be one
        return Markup(escape(f"{int(value)}".replace("-", "−")))
    exponent = math.floor(math.log10(abs(value)))
    if -3 <= exponent < 5:
        decimals = max(digits - 1 - exponent, 0)
        text = f"{value:.{decimals}f}"
        return Markup(escape(text.replace("-", "−")))
    mantissa = (
        f"{value / 10.0**exponent:.{digits - 1}f}"
        if exponent > -300
        else f"{value:.{digits - 1}e}".split("e")[0]
    )
    if mantissa.lstrip("-").startswith("10"):
        mantissa, exponent = mantissa.replace("10", "1", 1), exponent + 1
    mantissa = mantissa.replace("-", "−")
    power = f"10<sup>{str(exponent).replace('-', '−')}</sup>"
    return Markup(f'<span class="num">{mantissa}&thinsp;×&thinsp;{power}</span>')


def compact(value: float | None) -> Markup:
    """A limit or a power: shortest form, ``1 × 10^-4`` written as ``10^-4``."""
    if value is None or not math.isfinite(value):
        return NOTHING
    if value == 0:
        return Markup("0")
    exponent = math.floor(math.log10(abs(value)) + 1e-12)
    if -3 <= exponent < 5:
        return Markup(escape(f"{value:g}".replace("-", "−")))
    mantissa = value / 10.0**exponent
    power = f"10<sup>{str(exponent).replace('-', '−')}</sup>"
    if abs(mantissa - 1.0) < 1e-9:
        return Markup(power)
    return Markup(f'<span class="num">{mantissa:.3g}&thinsp;×&thinsp;{power}</span>')


def margin(value: float | None, kind: str = "reference") -> Markup:
    """A margin: limit over observed; counts are met or not."""
    if kind == "non-regression" and value is not None and value >= 1.0:
        return Markup("met")
    if value is None:
        return Markup("exact")
    if value >= 1000:
        return Markup("&gt;&thinsp;1000")
    return number(value, 3 if value < 10 else 2)


SIGNS = (
    (r"\bnu\b", "ν"), (r"\blambda\b", "λ"), (r"\bkappa\b", "κ"), (r"\btheta\b", "θ"), (r"\bpsi\b", "ψ"),
    (r"\brho\b", "ρ"), (r"\bpi\b", "π"), (r"sqrt\((\d+)\)", r"√\1"), (r"\^2\b", "²"), (r"\^3\b", "³"),
    (r"\^4\b", "⁴"), (r"\bL2\b", "L²"), (r"\bL3\b", "L³"), (r"\^T\b", "ᵀ"), (r" -> ", " → "),
    (r"\bm4\b", "m⁴"), (r"\b(\d(?:\.\d+)?)e-0?(\d+)\b", r"\1 × 10⁻\2"),
)  # fmt: skip
RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


def pretty(text: str) -> str:
    """Plain text of a case file with Greek letters and powers as a reader expects them."""
    for pattern, sign in SIGNS:
        text = re.sub(pattern, sign, text)
    return re.sub(r"⁻(\d+)", lambda m: "⁻" + m[1].translate(RAISED), text)


def pascal(value: float) -> str:
    """A modulus in Pa, MPa or GPa."""
    for size, unit in ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa")):
        if size <= value < 1e3 * size:
            return f"{value / size:g} {unit}"
    return f"{value:g} Pa"


def seconds(value: float | None) -> Markup:
    """A duration in the unit that reads best."""
    if value is None:
        return NOTHING
    if value < 0.9995e-3:
        return Markup(f"{value * 1e6:.0f}&thinsp;µs")
    if value < 0.9995:
        return Markup(f"{value * 1e3:.3g}&thinsp;ms")
    return Markup(f"{value:.3g}&thinsp;s")
