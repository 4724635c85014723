"""See ../check.sh, which calls this: main.py FOLDER_OF_DEPLOY_K8S WORK_FOLDER."""
import os
import pathlib
import shutil
import subprocess
import sys

import yaml

import manifests
import prometheus
from kubernetes_types import KubernetesTypes
from programs import Programs

OVERLAYS = ("single", "scaled", "job")
DOCKERFILE = pathlib.Path(__file__).resolve().parents[3] / "Dockerfile"


def render(here, name):
    result = subprocess.run(["kubectl", "kustomize", str(here / "overlays" / name)], capture_output=True, text=True, check=False)
    if result.returncode != 0:
        return None, [f"does not render: {result.stderr.strip()}"]
    return manifests.Overlay(name, [m for m in yaml.safe_load_all(result.stdout) if m]), []


def static_errors(overlay, types):
    errors = []
    for m in overlay.manifests:
        errors += [f"{m.get('kind')}/{m.get('metadata', {}).get('name')}: {e}" for e in types.errors(m)]
    if errors:
        return errors  # the rules take types for granted
    return [e for rule in manifests.RULES for e in rule(overlay)] or manifests.as_the_image(overlay, DOCKERFILE.read_text())


def program_errors(overlay, programs, here, folder, live):
    errors = prometheus.annotations(overlay) + prometheus.memory_alert(overlay)
    errors += prometheus.promtool(overlay, here / "check" / "alerts_test.yaml", folder)
    errors += prometheus.names(overlay, here / "overlays" / "scaled" / "prometheus-adapter.example.yaml", live)
    errors += programs.job(overlay)
    return errors + programs.nginx(overlay, here.parent / "nginx" / "cagefit.conf")


def main(here, folder):
    types = KubernetesTypes(os.path.realpath(shutil.which("kubectl")))
    programs = Programs(os.environ["CAGEFIT_BIN"], folder)
    overlays, errors = {}, {}
    for name in OVERLAYS:
        overlays[name], errors[name] = render(here, name)
        errors[name] = errors[name] or static_errors(overlays[name], types) or programs.settings(overlays[name])
    live = {}
    if not any(errors.values()):
        errors["single"], live = programs.live(overlays["single"])
        for name in OVERLAYS:
            errors[name] += program_errors(overlays[name], programs, here, folder, live)
        errors["scaled"] += manifests.same_pod(overlays["single"], overlays["scaled"])
    for name in OVERLAYS:
        for error in errors[name]:
            print(f"{name}: {error}")
        if errors[name]:
            print(f"{name}: {len(errors[name])} errors")
        elif live:
            print(f"{name}: {len(overlays[name].manifests)} manifests are as they should be")
        else:
            print(f"{name}: not tried to the end")
    failed = sum(1 for name in OVERLAYS if errors[name] or not live)
    print(f"{len(OVERLAYS) - failed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]), sys.argv[2]))
