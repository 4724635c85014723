"""Tries what the manifests say with the real programs: settings, metrics and health of cagefitd, the Job, nginx."""
import contextlib
import functools
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import time
import urllib.request

import prometheus
from manifests import container_ports, quantity

WAIT_SECONDS = 20  # for anything that should come to pass at once
GRACE = 1.0        # cagefitd's own promise: gone a second after the drain


def run(command, environment=None):
    variables = {"PATH": os.environ["PATH"], **(environment or {})}
    return subprocess.run([str(c) for c in command], env=variables, capture_output=True, text=True, check=False, timeout=120)


def until(condition):
    """Whether it comes true in time."""
    end = time.monotonic() + WAIT_SECONDS
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.1)
    return False


def server_pod(overlay):
    """(name, pod, container) of cagefitd, or None."""
    return next(((n, p, c) for n, _, p in overlay.pods() for c in p["containers"] if c["name"] == "cagefitd"), None)


def is_open(port):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def probes(container):
    return {name: probe for name, probe in container.items() if name.endswith("Probe")}


class Programs:
    def __init__(self, folder_of_programs, folder):
        self.cagefit, self.cagefitd = (pathlib.Path(folder_of_programs, name) for name in ("cagefit", "cagefitd"))
        self.folder = pathlib.Path(folder)

    @functools.cached_property
    def capture(self):
        """A folder of three frames."""
        folder = self.folder / "capture"
        made = run([self.cagefit, "synth", "tube", "--frames", 3, "--points", 4000, "--out", folder])
        if made.returncode != 0:
            raise SystemExit(f"check: {self.cagefit} makes no capture: {made.stderr}")
        return folder

    def settings(self, overlay):
        """cagefitd takes the pod's variables, and they fit the rest of the pod."""
        if server_pod(overlay) is None:
            return []
        name, pod, container = server_pod(overlay)
        printed = run([self.cagefitd, *container.get("args", []), "--print-config"], overlay.environment(container))
        if printed.returncode != 0:
            return [f"{name}: {printed.stderr.strip()}"]
        setting = dict(line.split("=", 1) for line in printed.stdout.splitlines() if line and not line.startswith("#"))
        values = {key: value.strip('"') for key, value in setting.items()}
        ports = {key: int(values[key].rsplit(":", 1)[1]) for key in ("listen", "health-listen", "metrics-listen")}
        needed = float(values["drain-seconds"]) + float(values["drain-delay"]) + GRACE
        limit = quantity(container["resources"]["limits"]["memory"])
        mounts = [m["mountPath"] for m in container["volumeMounts"] if not m.get("readOnly")]
        store = values["store"]
        checks = {
            f"terminationGracePeriodSeconds above {needed:g} s, which is drain, delay and one":
                pod.get("terminationGracePeriodSeconds", 30) > needed,
            "ports as the settings have them": container_ports(pod) == {
                "grpc": ports["listen"], "health": ports["health-listen"], "metrics": ports["metrics-listen"]},
            "probes at the health port": {p["grpc"]["port"] for p in probes(container).values()} == {ports["health-listen"]},
            "the store on a volume, or in a database": store.startswith("postgres:") or any(
                store.startswith(f"sqlite:{m}/") and m != "/tmp" for m in mounts),
            "templates within the fifth of the memory that the server leaves":
                int(values["template-memory-mib"]) << 20 <= limit / 5,
            "threads as its limit of CPUs": int(values["threads"]) == quantity(container["resources"]["limits"]["cpu"]),
            "a delay in front of draining, where there is another server to go to":
                (float(values["drain-delay"]) >= 10) == (overlay.find("HorizontalPodAutoscaler", "cagefitd") is not None),
        }
        return [f"{name}: wanted {what}" for what, is_so in checks.items() if not is_so]

    @contextlib.contextmanager
    def server(self, environment, *flags, grace=60):
        """(process, {what: address}) of a cagefitd that ends afterwards."""
        log = self.folder / f"cagefitd-{time.monotonic_ns()}.log"
        with log.open("w") as err:
            process = subprocess.Popen([str(self.cagefitd), *map(str, flags)], stdout=subprocess.PIPE, stderr=err, text=True,
                                       env={"PATH": os.environ["PATH"], **environment})
        try:
            addresses = {}
            wanted = 1 + ("--health-listen" in flags) + ("--metrics-listen" in flags)
            while len(addresses) < wanted:
                line = process.stdout.readline()
                if not line:
                    raise SystemExit(f"check: cagefitd does not start: {log.read_text()}")
                what, _, address = line.strip().partition(" on ")
                addresses[what] = address
            yield process, addresses
        finally:
            with contextlib.suppress(ProcessLookupError):
                process.send_signal(signal.SIGTERM)
            try:
                process.wait(grace)
            except subprocess.TimeoutExpired:
                process.kill()

    def live(self, overlay):
        """Errors, and the metrics of a server that ran with the overlay's settings: with frames, then with a broken store."""
        name, _, container = server_pod(overlay)
        store = self.folder / "live.db"
        free = "127.0.0.1:0"
        errors = []
        with self.server(overlay.environment(container), "--listen", free, "--health-listen", free, "--metrics-listen", free,
                         "--store", f"sqlite:{store}") as (process, addresses):
            def health(service):
                return run([self.cagefit, "health", "--server", addresses["health"], "--service", service]).returncode

            def metrics():
                with urllib.request.urlopen(f"http://{addresses['metrics']}/metrics", timeout=5) as page:
                    return page.read().decode()
            services = {p: probe["grpc"].get("service", "") for p, probe in probes(container).items()}
            errors += [f"{name}: {p} of {s!r} fails at a healthy server" for p, s in services.items() if health(s) != 0]
            fit = run([self.cagefit, "fit", self.capture, "--vertices", 200, "--server", addresses["listening"], "--quick",
                       "--keep-session", "--out", self.folder / "live"])
            if fit.returncode != 0:
                errors.append(f"a fit ends with {fit.returncode}: {fit.stderr}")
            # A store that is away: a folder where its file was.
            store.rename(self.folder / "live.db.away")
            store.mkdir()

            def is_away():
                run([self.cagefit, "session", "list", "--server", addresses["listening"]])
                return 'reason="STORE_UNAVAILABLE"' in metrics() and "\ncagefit_ready 0" in metrics()
            if not until(is_away):
                errors.append("a store that is away does not show in the metrics")
            states = {p: health(s) for p, s in services.items()}
            if states != {"startupProbe": 0, "livenessProbe": 0, "readinessProbe": 1}:
                errors.append(f"{name}: without a store its probes give {states}, expected 0 but for readiness")
            series = prometheus.parse_exposition(metrics())
            began = time.monotonic()
            process.send_signal(signal.SIGTERM)
            process.wait(60)
            if time.monotonic() - began > 5:
                errors.append(f"{name}: an idle server takes {time.monotonic() - began:.1f} s to end")
        return errors, series

    def job(self, overlay):
        """The Job's command fits a take, does nothing the second time, and its rules know what a missing take ends with."""
        errors = []
        for m in overlay.of("Job"):
            container = m["spec"]["template"]["spec"]["containers"][0]
            environment = overlay.environment(container)
            takes, fitted = self.folder / "takes", self.folder / "fitted"
            shutil.copytree(self.capture, takes / environment["TAKE"], ignore=shutil.ignore_patterns("truth"))

            def command(take):
                variables = {**environment, "TAKE": take}
                for argument in container["args"]:
                    text = re.sub(r"\$\((\w+)\)", lambda v: variables[v[1]], argument)
                    yield re.sub("^/takes", str(takes), re.sub("^/fitted", str(fitted), text))
            first = run([self.cagefit, *command(environment["TAKE"])], environment)
            frames = list((fitted / environment["TAKE"] / "frames").glob("*.obj"))
            if first.returncode != 0 or len(frames) != 3:
                errors.append(f"its command ends with {first.returncode} and {len(frames)} of 3 frames: {first.stderr}")
            times = {f: f.stat().st_mtime_ns for f in frames}
            again = run([self.cagefit, *command(environment["TAKE"])], environment)
            if again.returncode != 0 or times != {f: f.stat().st_mtime_ns for f in frames}:
                errors.append(f"the second time it ends with {again.returncode}, or writes frames again: {again.stderr}")
            missing = run([self.cagefit, *command("no-such-take")], environment).returncode
            rules = m["spec"]["podFailurePolicy"]["rules"]
            final = [v for r in rules if r["action"] == "FailJob" for v in r["onExitCodes"]["values"]]
            if missing == 0 or missing not in final:
                errors.append(f"a missing take ends with {missing}, which is none of the final {final}")
        return errors

    def nginx(self, overlay, original):
        """The files of nginx's ConfigMap, with other ports and folders, send calls to the servers that are there."""
        data = overlay.config("cagefit-nginx")
        if not data:
            return []
        if data["cagefit.conf"] != original.read_text():
            return [f"nginx's cagefit.conf is not the same as {original}"]
        run_folder, config, names = (self.folder / n for n in ("nginx-run", "nginx-config", "names"))
        ports = []
        for _ in range(2):
            with socket.socket() as free:
                free.bind(("127.0.0.1", 0))
                ports.append(free.getsockname()[1])
        front, port = ports
        config.mkdir()
        for name, text in data.items():
            text = text.replace("/tmp/nginx", str(run_folder)).replace(":50051 max_fails", f":{port} max_fails")
            (config / name).write_text(text.replace("listen 50051", f"listen 127.0.0.1:{front}"))
        programs = self.folder / "bin"
        programs.mkdir()
        # As glibc's answers; one line of each socket type.
        (programs / "getent").write_text(
            f'#!/bin/sh\n[ "$1 $2" = "ahosts cagefitd" ] || exit 1\nfor a in $(cat {names}); do\n'
            '  echo "$a STREAM cagefitd"; echo "$a DGRAM"; echo "$a RAW"\ndone\n')
        (programs / "getent").chmod(0o755)
        names.write_text("")
        errors = []
        environment = {"PATH": f"{programs}:{os.environ['PATH']}:/usr/sbin"}
        log = (self.folder / "nginx.log").open("w")
        script = subprocess.Popen(["/bin/sh", str(config / "run.sh"), str(config)], env=environment, start_new_session=True,
                                  stdout=log, stderr=log)

        def expect(code, what):
            ask = [self.cagefit, "health", "--server", f"127.0.0.1:{front}", "--timeout", 2]
            if not until(lambda: run(ask).returncode == code):
                errors.append(f"nginx: {what}: not {code}: {pathlib.Path(log.name).read_text()[-500:]}")
        try:
            if not until(lambda: is_open(front)):
                errors.append(f"nginx: it does not listen: {pathlib.Path(log.name).read_text()[-500:]}")
            expect(3, "without a server calls are UNAVAILABLE")
            one, two = (self.server({}, "--listen", f"127.0.0.{k}:{port}", "--store", "memory") for k in (2, 3))
            with one:
                names.write_text("127.0.0.2")
                expect(0, "a server that has come is called")
                names.write_text("127.0.0.3 127.0.0.2")
                with two:
                    until(lambda: "127.0.0.3" in (run_folder / "cagefit_replicas.conf").read_text())
                    written = (run_folder / "cagefit_replicas.conf").read_text().split()[1::3]
                    if written != [f"127.0.0.2:{port}", f"127.0.0.3:{port}"]:
                        errors.append(f"nginx: its servers are {written}")
                    names.write_text("127.0.0.3")
                    until(lambda: "127.0.0.2" not in (run_folder / "cagefit_replicas.conf").read_text())
                    fit = run([self.cagefit, "fit", self.capture, "--vertices", 200, "--quick",
                               "--server", f"127.0.0.1:{front}", "--out", self.folder / "through-nginx"])
                    if fit.returncode != 0:
                        errors.append(f"nginx: a fit through it ends with {fit.returncode}: {fit.stderr}")
                    names.write_text("")
                    time.sleep(3)
                    if "127.0.0.3" not in (run_folder / "cagefit_replicas.conf").read_text():
                        errors.append("nginx: an empty answer of DNS is taken for no servers")
                    expect(0, "an empty answer of DNS changes nothing")
        finally:
            os.killpg(script.pid, signal.SIGTERM)
            script.wait(30)
            log.close()
        return errors
