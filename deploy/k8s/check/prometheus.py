"""What alerts, the dashboard and the autoscaler ask Prometheus for, held against what a server really exports."""
import copy
import json
import pathlib
import re
import shutil
import subprocess

import yaml

WORDS = {"and", "or", "unless", "by", "without", "on", "ignoring", "group_left", "group_right", "offset", "bool"}
MADE_BY_PROMETHEUS = {"up"}
ITS_LABELS = {"namespace", "pod", "job", "instance", "service", "le"}
SERIES = re.compile(r"([a-zA-Z_:][a-zA-Z0-9_:]*)\s*(\{[^}]*\})?")


def selectors(expression):
    """(metric, {label: (operator, value)}) of each series in an expression of PromQL."""
    strings = []

    def keep(match):
        strings.append(match.group(0)[1:-1])
        return f"@{len(strings) - 1}@"
    text = re.sub(r"\"[^\"]*\"", keep, expression)
    text = re.sub(r"\[[^\]]*\]|\b(offset\s+\S+)", " ", text)
    text = re.sub(r"\b(by|without|on|ignoring|group_left|group_right)\s*\([^)]*\)", " ", text)
    for match in SERIES.finditer(text):
        name, inside = match.groups()
        before, after = text[:match.start()], text[match.end():].lstrip()
        if name in WORDS or after.startswith("(") and not inside or re.search(r"[0-9@$]$", before):
            continue
        labels = re.findall(r"([a-z_]+)\s*(=~|!~|!=|=)\s*@(\d+)@", inside or "")
        yield name, {label: (operator, strings[int(at)]) for label, operator, at in labels}


def parse_exposition(text):
    """{metric: [labels]} of a /metrics page, histograms by their series; families without a series have none."""
    series = {m: [] for m in re.findall(r"^# TYPE (\S+) ", text, re.M)}
    for name, labels in re.findall(r"^([a-z_]+)(?:\{(.*)\})? \S+$", text, re.M):
        series.setdefault(name, []).append(dict(re.findall(r'([a-z_]+)="([^"]*)"', labels)))
    return series


def unknown_series(expression, live):
    errors = []
    for metric, labels in selectors(expression):
        if metric in MADE_BY_PROMETHEUS:
            continue
        if metric not in live:
            errors.append(f"no server has a metric {metric}: {expression}")
            continue
        for label, (operator, value) in labels.items():
            if label in ITS_LABELS or "$" in value:
                continue
            known = {s.get(label) for s in live[metric]}
            wanted = value.split("|") if operator == "=~" else [value]
            if not known.intersection(wanted):
                errors.append(f"{metric} has no {label} {value}, but {sorted(map(str, known))}")
    return errors


def dashboard_expressions(overlay):
    for data in (m["data"] for m in overlay.of("ConfigMap") if m["metadata"].get("labels", {}).get("grafana_dashboard")):
        for text in data.values():
            dashboard = json.loads(text)
            for panel in dashboard["panels"]:
                yield from (t["expr"] for t in panel["targets"])
            for variable in dashboard["templating"]["list"]:
                if variable["query"].startswith("label_values("):
                    yield variable["query"].removeprefix("label_values(").rsplit(",", 1)[0]


def names(overlay, adapter_file, live):
    errors, count = [], 0
    expressions = [r["expr"] for m in overlay.of("PrometheusRule") for g in m["spec"]["groups"] for r in g["rules"]]
    expressions += dashboard_expressions(overlay)
    for m in overlay.of("HorizontalPodAutoscaler"):
        for metric in (s["pods"]["metric"] for s in m["spec"]["metrics"]):
            matchers = ",".join(f'{k}="{v}"' for k, v in metric["selector"]["matchLabels"].items())
            expressions.append(f"{metric['name']}{{{matchers}}}")
            adapter = yaml.safe_load(adapter_file.read_text())["rules"]["custom"]
            if metric["name"] not in [rule["name"]["as"] for rule in adapter]:
                errors.append(f"the adapter's example gives no {metric['name']}")
    for expression in expressions:
        count += len(list(selectors(expression)))
        errors += unknown_series(expression, live)
    if expressions and count < len(expressions):
        errors.append("fewer series than expressions: the reading of expressions is broken")
    return errors


def annotations(overlay):
    return [f"alert {r['alert']} does not say what it means and what to do"
            for m in overlay.of("PrometheusRule") for g in m["spec"]["groups"] for r in g["rules"]
            if not r["annotations"].get("summary") or len(r["annotations"].get("runbook", "")) < 100]


def memory_alert(overlay):
    """The number in the rule is the container's limit."""
    errors = []
    for m in overlay.of("PrometheusRule"):
        rule = next(r for g in m["spec"]["groups"] for r in g["rules"] if r["alert"] == "CagefitMemoryNearLimit")
        gib = int(re.search(r"> 0\.85 \* (\d+) \* 1024 \^ 3$", rule["expr"]).group(1))
        for name, _, pod in overlay.pods():
            container = pod["containers"][0]
            if container["name"] == "cagefitd" and container["resources"]["limits"]["memory"] != f"{gib}Gi":
                errors.append(f"{name}: its limit of memory is not the {gib}Gi of CagefitMemoryNearLimit")
    return errors


def promtool(overlay, tests, folder):
    """Syntax of the rules, and their unit tests."""
    rules = [m["spec"] for m in overlay.of("PrometheusRule")]
    if not rules:
        return []
    work = pathlib.Path(folder, f"rules-{overlay.name}")
    work.mkdir()
    without_runbooks = copy.deepcopy(rules[0])
    for rule in (r for g in without_runbooks["groups"] for r in g["rules"]):
        rule["annotations"].pop("runbook", None)
    (work / "all.yaml").write_text(yaml.safe_dump(rules[0]))
    (work / "rules.yaml").write_text(yaml.safe_dump(without_runbooks))
    shutil.copy(tests, work / "tests.yaml")
    errors = []
    for command in (["check", "rules", "--lint=all", "--lint-fatal", "all.yaml"], ["test", "rules", "tests.yaml"]):
        result = subprocess.run(["promtool", *command], cwd=work, capture_output=True, text=True, check=False)
        if result.returncode != 0:
            errors.append(f"promtool {' '.join(command)}: {result.stdout}{result.stderr}")
    tested = set(re.findall(r"alertname: *(\w+)", tests.read_text()))
    alerts = {r["alert"] for g in rules[0]["groups"] for r in g["rules"]}
    if tested != alerts:
        errors.append(f"alerts without a test, or tests without an alert: {', '.join(sorted(tested ^ alerts))}")
    return errors
