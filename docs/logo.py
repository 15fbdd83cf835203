"""Draw the logo into docs/logo.svg, and the social picture into docs/social.png: `python -m docs.logo`.

The logo is a joint in cross-section: a hose on the outside of a slotted cylinder pulls a strap, which goes through the
slot and turns a cam. Its three colours stand out from white and from black. The picture needs chromium.
"""

from io import BytesIO
from math import atan2, cos, hypot, pi, radians, sin
from pathlib import Path

from PIL import Image

from tests.pages.browsers import chromium

FOLDER = Path(__file__).parent
HOSE, STRAP, METAL = "#2f86c1", "#d9622b", "#7c8894"
SOCIAL_SIZE = (1280, 640)

Point = tuple[float, float]
CYLINDER, CYLINDER_RADIUS = (37.0, 30.5), 17.0
HOSE_RADIUS, HOSE_ENDS = 24.5, (radians(108.0), radians(268.0))  # of the middle of the hose
SLOT = (radians(8.0), radians(76.0))
STRAP_LEAVES = radians(52.0)  # where the strap leaves the circle of the hose
CAM, CAM_RADIUS, NOSE, NOSE_RADIUS = (39.0, 32.0), 8.0, (33.5, 36.5), 3.8
BORE_RADIUS = 2.5
STRAP_END = radians(285.0)  # where the strap is clamped to the cam


def polar(centre: Point, radius: float, angle: float) -> Point:
    """Return a point of a circle; angles are anticlockwise from x to the right, y is downwards."""
    return centre[0] + radius * cos(angle), centre[1] - radius * sin(angle)


def tangent_angle(point: Point, centre: Point, radius: float) -> float:
    """Return the angle at which the right-hand tangent from a point above touches a circle."""
    x, y = point[0] - centre[0], centre[1] - point[1]
    return atan2(y, x) - atan2((hypot(x, y) ** 2 - radius**2) ** 0.5, radius)


def arc(centre: Point, radius: float, first: float, last: float) -> str:
    """Return the commands of an SVG path for an arc from the current point, which is at the angle `first`."""
    x, y = polar(centre, radius, last)
    large, clockwise = int(abs(last - first) > pi), int(last < first)
    return f"A{radius:g} {radius:g} 0 {large} {clockwise} {x:.2f} {y:.2f}"


def move_to(point: Point) -> str:
    """Return the command of an SVG path that begins at a point."""
    return f"M{point[0]:.2f} {point[1]:.2f}"


def cam_path() -> str:
    """Return the convex hull of the cam's two circles as an SVG path."""
    x, y = NOSE[0] - CAM[0], CAM[1] - NOSE[1]
    spread = atan2((hypot(x, y) ** 2 - (CAM_RADIUS - NOSE_RADIUS) ** 2) ** 0.5, CAM_RADIUS - NOSE_RADIUS)
    first, last = atan2(y, x) + spread, atan2(y, x) - spread
    around = arc(CAM, CAM_RADIUS, last + 2.0 * pi, first)
    nose = polar(NOSE, NOSE_RADIUS, first)
    tip = f"L{nose[0]:.2f} {nose[1]:.2f}{arc(NOSE, NOSE_RADIUS, first, last)}Z"
    return move_to(polar(CAM, CAM_RADIUS, last)) + around + tip


def logo() -> str:
    """Return the text of the logo's SVG file."""
    cylinder = move_to(polar(CYLINDER, CYLINDER_RADIUS, SLOT[1])) + arc(
        CYLINDER, CYLINDER_RADIUS, SLOT[1], SLOT[0] + 2.0 * pi
    )
    hose = move_to(polar(CYLINDER, HOSE_RADIUS, HOSE_ENDS[0])) + arc(CYLINDER, HOSE_RADIUS, *HOSE_ENDS)
    leaves, touched = polar(CYLINDER, HOSE_RADIUS, STRAP_LEAVES), CAM_RADIUS + 1.5
    meets = tangent_angle(leaves, CAM, touched)
    x, y = polar(CAM, touched, meets)
    strap = (
        move_to(polar(CYLINDER, HOSE_RADIUS, HOSE_ENDS[0]))
        + arc(CYLINDER, HOSE_RADIUS, HOSE_ENDS[0], STRAP_LEAVES)
        + f"L{x:.2f} {y:.2f}"
        + arc(CAM, touched, meets, STRAP_END - 2.0 * pi)
    )
    radius = BORE_RADIUS
    bore = (
        f"M{CAM[0] + radius} {CAM[1]}a{radius} {radius} 0 1 0 -{2 * radius} 0a{radius} {radius} 0 1 0 {2 * radius} 0Z"
    )
    return f"""<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 64 64" width="64" height="64" role="img">
<title>layflat</title>
<g fill="none" stroke-linecap="round" stroke-linejoin="round">
<path d="{cylinder}" stroke="{METAL}" stroke-width="4"/>
<path d="{strap}" stroke="{STRAP}" stroke-width="3"/>
<path d="{hose}" stroke="{HOSE}" stroke-width="9"/>
</g>
<path d="{cam_path()}{bore}" fill="{METAL}" fill-rule="evenodd"/>
</svg>
"""


def social_page(picture: str) -> str:
    """Return the HTML of the social picture: a picture (SVG) beside name and slogan."""
    return f"""<style>
body {{ margin: 0; display: flex; align-items: center; gap: 72px; height: 640px; padding: 0 96px;
  box-sizing: border-box; background: #fff; color: #1d2a36; font-family: "DejaVu Sans", Arial, sans-serif; }}
svg {{ width: 360px; height: 360px; flex: none; }}
h1 {{ margin: 0 0 24px; font-size: 112px; letter-spacing: -2px; }}
p {{ margin: 0; font-size: 38px; line-height: 1.35; color: #44525f; }}
</style>
{picture}
<div><h1>layflat</h1><p>Design, simulate and control<br>low-cost robot joints<br>made of layflat hose</p></div>
"""


def main() -> None:
    """Write docs/logo.svg, and docs/social.png as chromium shows it."""
    (FOLDER / "logo.svg").write_text(logo(), encoding="utf-8")
    with chromium() as browser:
        page = browser.new_page(viewport=dict(zip(("width", "height"), SOCIAL_SIZE, strict=True)))
        page.set_content(social_page(logo()))
        Image.open(BytesIO(page.screenshot())).convert("RGB").save(FOLDER / "social.png", optimize=True)


if __name__ == "__main__":
    main()
