"""The page of `cagefit fit --report`, opened in a browser without a network. Usage: report_in_a_browser.py CAGEFIT CHROMIUM"""
import html.parser
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

FRAMES, REFUSED = 9, 4
WIDTH, HEIGHT = 1100, 800
STAGE = (0xEC, 0xEE, 0xF1)  # behind the surface, in the light scheme
VOID = {"area", "base", "br", "col", "hr", "img", "input", "link", "meta"}
cagefit, chromium = sys.argv[1:3]


class Page(html.parser.HTMLParser):
    """Elements as (name, attributes, text), text that of the element alone."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.open = [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        element = [tag, dict(attrs), ""]
        self.elements.append(element)
        if tag not in VOID:
            self.open.append(element)

    def handle_endtag(self, tag):
        while self.open and self.open.pop()[0] != tag:
            pass

    def handle_data(self, data):
        if self.open:
            self.open[-1][2] += data

    def all(self, tag):
        return [element for element in self.elements if element[0] == tag]

    def __getitem__(self, name):
        return next(element for element in self.elements if element[1].get("id") == name)


def browse(url, picture, profile):
    """The page's elements once it has come to rest, in text; the window goes to `picture`."""
    command = [chromium, "--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
               "--hide-scrollbars", "--host-resolver-rules=MAP * ~NOTFOUND", "--blink-settings=preferredColorScheme=1",
               "--force-device-scale-factor=1",
               f"--user-data-dir={profile}", f"--window-size={WIDTH},{HEIGHT}", "--virtual-time-budget=20000", "--dump-dom",
               f"--screenshot={picture}", url]
    done = subprocess.run(command, capture_output=True, timeout=180, check=False, env={**os.environ, "HOME": profile})
    assert done.returncode == 0, done.stderr.decode(errors="replace")
    return done.stdout.decode()


def unfilter(kind, line, above, pixel):
    """Undoes a PNG filter in place."""
    for i, value in enumerate(line):
        a = line[i - pixel] if i >= pixel else 0
        b, c = above[i], above[i - pixel] if i >= pixel else 0
        nearest = min((abs(b - c), 0, a), (abs(a - c), 1, b), (abs(a + b - 2 * c), 2, c))[2]
        line[i] = (value + (0, a, b, (a + b) // 2, nearest)[kind]) & 255


def read_png(path):
    """Rows of (red, green, blue), of a picture without interlacing."""
    data, at, packed = path.read_bytes(), 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IHDR":
            width, height, depth, color, _, _, interlaced = struct.unpack(">IIBBBBB", data[at + 8:at + 8 + size])
        elif kind == b"IDAT":
            packed += data[at + 8:at + 8 + size]
        at += size + 12
    assert (depth, interlaced) == (8, 0) and color in (2, 6)
    pixel = 3 if color == 2 else 4
    raw, stride, above, rows = zlib.decompress(packed), width * pixel, bytearray(width * pixel), []
    for y in range(height):
        begin = y * (stride + 1)
        line = bytearray(raw[begin + 1:begin + 1 + stride])
        if raw[begin]:
            unfilter(raw[begin], line, above, pixel)
        rows.append([tuple(line[i:i + 3]) for i in range(0, stride, pixel)])
        above = line
    return rows


def view_of(rows):
    """Pixels of the 3D view: the box of what has its background."""
    ys = [y for y, row in enumerate(rows) if row.count(STAGE) > WIDTH // 20]
    xs = [x for x in range(len(rows[0])) if sum(rows[y][x] == STAGE for y in ys) > len(ys) // 10]
    assert ys and xs, "no 3D view"
    return [row[xs[0]:xs[-1] + 1] for row in rows[ys[0]:ys[-1] + 1]]


def check_page(page, frame):
    assert page["error"][1].get("hidden") is not None, page["error"][2]
    body = page.all("body")[0][1].get("class", "")
    assert "ready" in body.split() and "no-scene" not in body, body
    rows = [row for row in page.all("tr") if row[1].get("class") is not None]
    states = [row[1]["class"].split() for row in rows if row[1]["class"]]
    assert len(states) == FRAMES, states
    assert [k for k, marks in enumerate(states) if "refused" in marks] == [REFUSED], states
    assert [k for k, marks in enumerate(states) if "current" in marks] == [frame], states
    assert sum("worst" in marks for marks in states) == 3, states
    assert page["frame-title"][2] == f"Frame {frame}: {'refused' if frame == REFUSED else 'ok'}", page["frame-title"][2]
    assert (page["notice"][1].get("hidden") is None) == (frame == REFUSED), page["notice"]
    assert len(page.all("figure")) == 3, "distances, energies, time"
    assert page["position"][2] == f"{frame} / {FRAMES - 1}"
    assert any(cell[2] == "not Draco: the bytes do not begin with \"DRACO\"" for cell in page.all("td"))


def check_view(view):
    pixels = [pixel for row in view for pixel in row]
    drawn = [pixel for pixel in pixels if pixel != STAGE]
    assert 0.05 < len(drawn) / len(pixels) < 0.9, f"{len(drawn)} of {len(pixels)} pixels are drawn"
    assert len(set(drawn)) > 500, f"{len(set(drawn))} colours"
    return pixels


def main(folder):
    capture, out, profile = folder / "capture", folder / "out", str(folder / "profile")
    subprocess.run([cagefit, "synth", "tube", "--out", capture, "--frames", str(FRAMES), "--points", "5000"], check=True)
    (capture / f"frame_{REFUSED:04}.drc").write_bytes(b"no Draco")
    fitted = subprocess.run([cagefit, "fit", capture, "--out", out, "--vertices", "200", "--quick", "--report"], check=False)
    assert fitted.returncode == 4, "one frame is refused"
    assert (out / "report.html").stat().st_size < 5e6
    views = {}
    for frame in (0, REFUSED, FRAMES - 1):
        url = f"{(out / 'report.html').as_uri()}#frame={frame}"
        picture = folder / f"{frame}.png"
        check_page(Page(browse(url, picture, profile)), frame)
        views[frame] = check_view(view_of(read_png(picture)))
    for a, b in ((0, REFUSED), (REFUSED, FRAMES - 1)):
        assert len(views[a]) == len(views[b]), "the view keeps its size"
        other = sum(x != y for x, y in zip(views[a], views[b])) / len(views[a])
        assert other > 0.05, f"frames {a} and {b} differ in {other:.1%} of the view"
    print(f"{len(views)} of {FRAMES} frames looked at")


with tempfile.TemporaryDirectory() as temporary:
    main(pathlib.Path(temporary))
