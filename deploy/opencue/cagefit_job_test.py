"""Tests cagefit_job.py without OpenCue: `outline` is a stand-in here, and the frames run as a host of the farm runs them.

    python3 deploy/opencue/cagefit_job_test.py        CAGEFIT: the program, default build/release/bin/cagefit

The stand-in has the calls of PyOutline that the script makes, with the names and defaults of its sources (outline/loader.py,
outline/layer.py, outline/modules/shell.py, outline/cuerun.py), writes the job as outline/backend/cue.py does, and refuses what
Cuebot refuses (JobSpec.java). It says nothing about a real farm.
"""
import filecmp
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import types
import unittest
import xml.etree.ElementTree as xml

PROGRAM = os.environ.get("CAGEFIT", str(pathlib.Path(__file__).resolve().parents[2] / "build/release/bin/cagefit"))
LAUNCHED = []  # specifications of jobs


class Outline:
    def __init__(self, name=None, frame_range=None, path=None, serialize=True, name_unique=False, current=False, shot=None,
                 show=None, user=None, facility=None, maxcores=None, maxgpus=None):
        self.name, self.shot, self.show, self.user, self.layers = name, shot, show, user, []

    def add_layer(self, layer):
        self.layers.append(layer)


class Shell:
    def __init__(self, name, **args):
        known = {"command", "range", "chunk", "cores", "threads", "overrideCores", "threadable", "memory", "env", "service", "tags",
                 "limits", "timeout", "timeout_llu", "type", "register", "require"}
        assert set(args) <= known, f"PyOutline would ignore {set(args) - known}"
        assert "command" in args, "Shell requires it"
        self.name, self.args = name, {"chunk": 1, "range": None, **args}


def launch(ol, use_pycuerun=True, **args):
    flags = {"pause": False, "priority": 1, "maxretries": "2", "wait": False, "test": False}
    assert set(args) <= set(flags), args
    flags.update(args)
    assert not use_pycuerun, "the command would be that of pycuerun"
    for name in (ol.name, ol.shot, *(layer.name for layer in ol.layers)):
        assert re.fullmatch(r"[\w.]{3,}", name.replace("-", "_")), name
    spec = xml.Element("spec")
    for key, value in (("show", ol.show), ("shot", ol.shot), ("user", ol.user)):
        xml.SubElement(spec, key).text = value
    job = xml.SubElement(spec, "job", {"name": ol.name})
    for key, value in (("paused", flags["pause"]), ("maxretries", flags["maxretries"])):
        xml.SubElement(job, key).text = str(value)
    for layer in ol.layers:
        element = xml.SubElement(job, "layer", {"name": layer.name})
        xml.SubElement(element, "cmd").text = " ".join(layer.args["command"])
        xml.SubElement(element, "range").text = str(layer.args["range"])
        xml.SubElement(element, "chunk").text = str(int(layer.args["chunk"]))
        if layer.args.get("overrideCores"):
            xml.SubElement(element, "cores").text = "%0.1f" % float(layer.args["cores"])
        assert re.fullmatch(r"\d+g|\d+(\.\d+)?m", layer.args["memory"].lower()), layer.args["memory"]
        xml.SubElement(element, "memory").text = layer.args["memory"]
        for key, value in layer.args.get("env", {}).items():
            xml.SubElement(element, "key", {"name": key}).text = value
    LAUNCHED.append(xml.tostring(spec).decode())  # fails for texts that are not str
    return [ol.name]


def install_stand_in():
    modules = {name: types.ModuleType(name) for name in ("outline", "outline.cuerun", "outline.modules", "outline.modules.shell")}
    modules["outline"].Outline = Outline
    modules["outline"].cuerun = modules["outline.cuerun"]
    modules["outline"].modules = modules["outline.modules"]
    modules["outline.modules"].shell = modules["outline.modules.shell"]
    modules["outline.cuerun"].launch = launch
    modules["outline.modules.shell"].Shell = Shell
    sys.modules.update(modules)


install_stand_in()
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import cagefit_job  # noqa: E402


def launch_job(*words):
    sys.argv = ["cagefit_job.py", "--show", "testing", "--shot", "shot01", "--cagefit", PROGRAM, *map(str, words)]
    cagefit_job.main()
    return xml.fromstring(LAUNCHED[-1])


class Host:
    """Starts a frame as RQD does: the command is a file for the shell, in another folder, in a session of its own."""

    def __init__(self, spec, folder):
        layer = spec.find("job/layer")
        self.command, self.folder = layer.find("cmd").text, folder
        self.environment = {**os.environ, **{key.get("name"): key.text for key in layer.findall("key")}}
        first, last = map(int, layer.find("range").text.split("-"))
        self.frames = range(first, last + 1)

    def start(self, frame):
        file = self.folder / f"rqd-cmd-{frame}"
        file.write_text(self.command.replace("#IFRAME#", str(frame)))
        return subprocess.Popen(["/bin/sh", file], cwd=self.folder, env=self.environment, start_new_session=True,
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    def run(self, frame):
        process = self.start(frame)
        messages = process.communicate()[1]
        return process.returncode, messages


class CagefitJobTest(unittest.TestCase):
    FRAMES = 12

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="it's a farm ")  # its name needs quotes
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.takes = [cls.folder / "takes" / f"take_{k}" for k in range(3)]
        for k, take in enumerate(cls.takes):
            subprocess.run([PROGRAM, "synth", "blob", "--seed", str(k), "--frames", str(cls.FRAMES), "--points", "10000", "--out",
                            take], check=True, stdout=subprocess.DEVNULL)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def test_the_job_has_a_frame_for_each_chunk(self):
        job = launch_job("--chunks", 2, "--cores", 8, "--memory", "6g", "--retries", 5, "--pause", "out", *self.takes).find("job")
        layer = job.find("layer")
        self.assertEqual([layer.find(key).text for key in ("range", "chunk", "cores", "memory")], ["0-1", "1", "8.0", "6g"])
        self.assertEqual((layer.find("key").get("name"), layer.find("key").text), ("CAGEFIT_THREADS", "8"))
        self.assertEqual([job.find(key).text for key in ("maxretries", "paused")], ["5", "True"])

    def test_without_chunks_each_take_is_a_frame(self):
        self.assertEqual(launch_job("out", *self.takes).find("job/layer/range").text, "0-2")

    def test_the_frames_fit_every_take_once(self):
        out = self.folder / "all"
        host = Host(launch_job("--chunks", 2, "--cores", 1, out, *self.takes, "--", "--vertices", 200), self.folder)
        begun = []
        for frame in host.frames:
            code, messages = host.run(frame)
            self.assertEqual(code, 0, messages)
            begun += re.findall(r"take (\w+): begins", messages)
        self.assertEqual(sorted(begun), ["take_0", "take_1", "take_2"])
        for take in self.takes:
            self.assertEqual(len(list((out / take.name / "frames").glob("*.obj"))), self.FRAMES)

    def test_a_killed_frame_goes_on_when_it_is_retried(self):
        host = Host(launch_job("--cores", 1, self.folder / "killed", self.takes[0], "--", "--vertices", 200), self.folder)
        fitted = self.folder / "killed" / "take_0" / "frames"
        process = host.start(0)
        while len(list(fitted.glob("*.obj"))) < 3 and process.poll() is None:
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGKILL)
        before = process.communicate()[1]
        self.assertEqual(process.returncode, -signal.SIGKILL, before)

        code, after = host.run(0)

        self.assertEqual(code, 0, after)
        self.assertIn("take_0: goes on", after)
        numbers = re.findall(r"^frame (\d+) of", before + after, re.MULTILINE)
        self.assertEqual(len(numbers), len(set(numbers)), "a frame was fitted twice")
        alone = self.folder / "alone"
        subprocess.run([PROGRAM, "fit", "--takes", self.takes[0], "--out", alone, "--vertices", "200"], check=True,
                       stderr=subprocess.DEVNULL, env=host.environment)
        names = [f"{k:04}.obj" for k in range(self.FRAMES)]
        same, _, _ = filecmp.cmpfiles(fitted, alone / "take_0" / "frames", names, shallow=False)
        self.assertEqual(same, names)

    def test_wrong_usage_fails_with_exit_code_2(self):
        code, messages = Host(launch_job(self.folder / "wrong", self.takes[0], "--", "--vertces", 200), self.folder).run(0)
        self.assertEqual(code, 2, messages)


if __name__ == "__main__":
    unittest.main(verbosity=2)
