#!/usr/bin/env python3
"""documented_commands.py SOURCE BUILD: runs the blocks of commands and code in README.md, long runs in a short form, and fails
for a block that it does not know. Blocks of deploy/*/README.md are run by the check beside them, most of which need packages and
rights of their own; here the scripts that they name have to exist and to parse."""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import types

SOURCE, BUILD = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
# What is added to a command so that it ends soon. The fuzz targets' short form is Fuzz.* of ctest.
SHORT = {
    "tests/run.sh": ["-N"],
    "tests/soak/run.sh kill_server": ["--kills", "1", "--frames", "20"],
    "deploy/scale/check.sh": ["--kills", "1", "--streams", "2", "--frames", "10", "--seconds", "2"],
    "tests/load/run.sh idle": ["--sessions", "40", "--minutes", "0.01"],
}
# They need other packages or rights than tests do, as the checks beside the pages of deploy/ do.
PARSED_ONLY = {"tests/fuzz/run.sh", "deploy/container/check.sh", "deploy/k8s/check.sh", "deploy/slurm/check.sh"}


def blocks(page):
    """Lists of lines that are indented by four behind an empty line."""
    found, before = [], ""
    for line in page.read_text().splitlines():
        if line.startswith("    ") and (before == "" or found and found[-1] and before == found[-1][-1]):
            if before == "":
                found.append([])
            found[-1].append(line)
        before = line
    return [[line[4:] for line in block] for block in found]


def run(command, cwd, **more):
    print("+", " ".join(map(str, command)), flush=True)
    result = subprocess.run(command, cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=500, **more)
    if result.returncode != 0:
        sys.exit(f"{result.stdout}\n{' '.join(map(str, command))}: exit code {result.returncode}")
    return result.stdout


def run_scripts(block, folder):
    """Scripts of this project, each with a comment behind it."""
    environment = {**os.environ, "CAGEFIT_DEMO_OUT": str(folder / "demo")}
    for line in block:
        command = line.split("#")[0].split()
        run(["bash", "-n", command[0]], SOURCE)
        if command[0] not in PARSED_ONLY:
            run(command + SHORT.get(" ".join(command), []), SOURCE, env=environment)


def synth(folder, name):
    run([BUILD / "bin/cagefit", "synth", "blob", "--out", name, "--frames", "2", "--points", "20000"], folder)


def run_server_and_fit(block, folder):
    """A server, then a fit on it from another machine."""
    serve, fit = ([str(BUILD / "bin" / line.split()[0]), *line.split()[1:]] for line in block)
    synth(folder, "capture")
    serve = [word.replace("0.0.0.0:50051", "127.0.0.1:0") for word in serve] + ["--store", "memory"]
    server = subprocess.Popen(serve, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        address = server.stdout.readline().split()[-1]
        run([{"rig:50051": address, "60": "1"}.get(word, word) for word in fit], folder)
    finally:
        server.terminate()
        server.wait()
    for file in ("frames/0001.obj", "cage.obj", "report.html"):
        assert (folder / "fitted" / file).exists(), file


def run_takes(block, folder):
    """Takes, here, and on Slurm, which deploy/slurm/check.sh does."""
    fit, batch = block
    for take in ("run", "walk"):
        synth(folder, f"captures/{take}")
    run(["bash", "-c", fit], folder, env={**os.environ, "PATH": f"{BUILD}/bin:{os.environ['PATH']}"})
    for file in ("run/sequence.glb", "walk/sequence.usda", "walk/report.html"):
        assert (folder / "fitted" / file).exists(), file
    run(["bash", "-n", batch.split()[2]], SOURCE)


def run_containers(block, _):
    """The Dockerfile has the same commands, and deploy/container/check.sh does what they do; deploy/k8s/check.sh the last."""
    dockerfile = (SOURCE / "Dockerfile").read_text()
    *docker, kubectl = block
    for line in docker:
        assert line in dockerfile, line
    assert (SOURCE / kubectl.split()[-1] / "kustomization.yaml").exists(), kubectl


def run_find_package(block, _):
    """The example, which InstalledLibrary builds, does the same."""
    example = (SOURCE / "client/example/CMakeLists.txt").read_text()
    for line in block:
        assert line.replace("rig", "stream_clouds") in example, line


def run_python(block, _):
    """A key frame and a delta of it."""
    names = {"origin": (1.0, 0.0, -1.0), "q": None}
    for key, packed, expected in ((True, [0, 2, 4], [1, 1, 1]), (False, [2, -2, 0], [2, 0, 1])):
        names["delta"] = types.SimpleNamespace(key=key, packed=packed, quantum=0.5)
        exec("\n".join(block), names)
        assert names["vertices"] == expected, names["vertices"]


KNOWN = {
    "deploy/demo.sh": run_scripts,
    "cagefitd --listen": run_server_and_fit,
    "cagefit fit --takes": run_takes,
    "docker build": run_containers,
    "tests/soak/run.sh": run_scripts,
    "find_package": run_find_package,
    "q = list": run_python,
}

count = 0
for block in blocks(SOURCE / "README.md"):
    runner = next((runner for start, runner in KNOWN.items() if block[0].startswith(start)), None)
    if runner is None:
        sys.exit(f"README.md: no runner for the block that begins with: {block[0]}")
    with tempfile.TemporaryDirectory() as folder:
        runner(block, pathlib.Path(folder))
    count += 1
if count != len(KNOWN):
    sys.exit(f"README.md has {count} blocks; expected {len(KNOWN)}")

for page in sorted(SOURCE.glob("deploy/*/README.md")):
    for check in page.parent.glob("*.sh"):
        run(["bash", "-n", check], SOURCE)
    for script in re.findall(r"\bdeploy/[\w/.-]+\.(?:sh|sbatch|py)\b", page.read_text()):
        assert (SOURCE / script).exists(), f"{page}: there is no {script}"
print(f"{count} blocks ran")
