"""client/python/fit_folder.py writes what `cagefit fit` writes. Usage: python_fit_folder.py STUBS FIT_FOLDER CAGEFIT CAGEFITD"""
import os
import pathlib
import subprocess
import sys
import tempfile

FRAMES = 4
stubs, fit_folder, cagefit, cagefitd = sys.argv[1:5]


def numbers(path, kind):
    """Of the lines of a kind."""
    return [float(value) for line in path.read_text().splitlines() if line.startswith(kind + " ") for value in line.split()[1:]]


def fit(*arguments):
    return subprocess.run([sys.executable, fit_folder, *arguments], env={**os.environ, "PYTHONPATH": stubs}, check=False).returncode


def main(folder):
    capture, ours, theirs = folder / "capture", folder / "ours", folder / "theirs"
    subprocess.run([cagefit, "synth", "blob", "--out", capture, "--frames", str(FRAMES), "--points", "5000"], check=True)
    subprocess.run([cagefit, "fit", capture, "--out", theirs, "--vertices", "150", "--quick"], check=True)
    with subprocess.Popen([cagefitd, "--listen", "127.0.0.1:0", "--log-level", "off", "--store", "memory"], stdout=subprocess.PIPE,
                          text=True) as server:
        try:
            address = server.stdout.readline().split()[-1]
            assert fit(capture, ours, "--server", address, "--vertices", "150") == 0
            assert fit(folder, ours, "--server", address) == 2, "no .drc files"
            (capture / "frame_0002.drc").write_bytes(b"no Draco")
            assert fit(capture, folder / "broken", "--server", address, "--vertices", "150") == 4, "a frame is refused"
        finally:
            server.terminate()
    for k in range(FRAMES):
        mine, other = ours / f"frame_{k:04}.obj", theirs / f"frames/{k:04}.obj"
        assert numbers(mine, "f") == numbers(other, "f"), k
        assert numbers(mine, "v") == numbers(other, "v"), f"frame {k}: other bits"
    print(f"{FRAMES} frames, equal to the bit")


with tempfile.TemporaryDirectory() as folder:
    main(pathlib.Path(folder))
