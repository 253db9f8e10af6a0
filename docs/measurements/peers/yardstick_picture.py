"""The picture of the yardstick: error under the push against time, both logarithmic, one panel for each amplitude."""

import math

PANEL, HEIGHT, LEFT, TOP, GAP = 330, 300, 70, 50, 60
TIMES, ERRORS = (1e-5, 1e3), (1e-6, 1e1)
COLOURS = {"vademecum": "#0b6e4f", "NumPy": "#8a6d00", "pyMOR": "#b0448f", "MuJoCo": "#c8450f", "Newton": "#4a6fb5", "Kratos": "#666666"}
RADII = {0.004: 5.5, 0.001: 4.0, 0.00025: 2.8}


def colour(program):
    return next(value for key, value in COLOURS.items() if program.startswith(key))


def along(value, limits, length):
    low, high = map(math.log10, limits)
    return length * (min(max(math.log10(value), low), high) - low) / (high - low)


def text(x, y, words, size=11, anchor="middle", extra=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" text-anchor="{anchor}"{extra}>{words}</text>'


def power(exponent):
    digits = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
    return "1" if exponent == 0 else "10" + str(exponent).translate(digits)


def panel(rows, left, title):
    x = lambda value: left + along(value, TIMES, PANEL)
    y = lambda value: TOP + HEIGHT - along(value, ERRORS, HEIGHT)
    parts = [f'<rect x="{left}" y="{TOP}" width="{PANEL}" height="{HEIGHT}" fill="none" stroke="#999"/>',
             text(left + PANEL / 2, TOP - 12, title, 13)]
    for exponent in range(-5, 4):
        at = x(10.0**exponent)
        parts.append(f'<line x1="{at:.1f}" x2="{at:.1f}" y1="{TOP}" y2="{TOP + HEIGHT}" stroke="#eee"/>')
        if exponent % 2 == 0:
            parts.append(text(at, TOP + HEIGHT + 16, power(exponent)))
    for exponent in range(-6, 2):
        at = y(10.0**exponent)
        parts.append(f'<line x1="{left}" x2="{left + PANEL}" y1="{at:.1f}" y2="{at:.1f}" stroke="#eee"/>')
        parts.append(text(left - 6, at + 4, power(exponent), anchor="end"))
    parts.append(f'<line x1="{x(1):.1f}" x2="{x(1):.1f}" y1="{TOP}" y2="{TOP + HEIGHT}" stroke="#444" stroke-dasharray="4 3"/>')
    parts.append(text(x(1) - 4, TOP + HEIGHT - 6, "real time", 10, "end"))
    parts.append(text(left + PANEL / 2, TOP + HEIGHT + 34, "seconds of computing for a second of motion"))
    series = {}
    for row in rows:
        error = row["same_mesh"] if row["own"] else row["body"]
        if error:
            settings = "".join(letter for letter in row["settings"] if not letter.isdigit())
            series.setdefault((row["program"], row["name"], settings.replace("`Euler`, ", "`Euler`"), row["settings"]
                               if row["program"] == "vademecum" else ""), []).append((row, error[0]))
    for found in series.values():
        first = found[0][0]
        ink = colour(first["program"])
        line = " ".join(f"{x(row['per_motion']):.1f},{y(error):.1f}" for row, error in found)
        parts.append(f'<polyline points="{line}" fill="none" stroke="{ink}" stroke-opacity="0.55"/>')
        for row, error in found:
            fill = ink if row["own"] else "#fff"
            hint = f"{row['program']}, {row['name']}, {row['settings'].replace('`', '')}, {1e3 * row['step']:g} ms: {error:.1e}"
            parts.append(f'<circle cx="{x(row["per_motion"]):.1f}" cy="{y(error):.1f}" r="{RADII[row["step"]]}" fill="{fill}" '
                         f'stroke="{ink}"><title>{hint}</title></circle>')
    return parts


def picture(small, large):
    width, height = LEFT + 2 * PANEL + GAP + 20, TOP + HEIGHT + 100
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" fill="#222">',
             f'<rect width="{width}" height="{height}" fill="#fff"/>']
    parts += panel(small, LEFT, "small displacements")
    parts += panel(large, LEFT + PANEL + GAP, "large displacements")
    middle = TOP + HEIGHT / 2
    parts.append(text(18, middle, "error under the push", extra=f' transform="rotate(-90 18 {middle})"'))
    at = LEFT
    shown = [name for name in COLOURS if any(row["program"].startswith(name) for row in small + large)]
    for name in shown:
        parts.append(f'<circle cx="{at}" cy="{height - 38}" r="5" fill="{COLOURS[name]}"/>')
        parts.append(text(at + 9, height - 34, name, 12, "start"))
        at += 30 + 8 * len(name)
    parts.append(text(LEFT, height - 12, "steps of 4, 1 and 0.25 ms: large, middle, small. Filled: against the converged motion of the "
                      "same tetrahedra; hollow: of the body.", 11, "start"))
    return "\n".join([*parts, "</svg>", ""])
