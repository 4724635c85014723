"""Rules that one overlay's manifests keep among each other. Each function returns errors, one line each."""
import copy
import re

WORKLOADS = ("Deployment", "StatefulSet", "Job")
# Made by whoever deploys, see secret.example.yaml.
OUTSIDE_SECRETS = {"cagefitd-postgres"}


def quantity(text):
    """Bytes or cores."""
    number, unit = re.fullmatch(r"([0-9.]+)(m|[KMGT]i?)?", str(text)).groups()
    powers = {None: 1, "m": 1e-3, **{u: 1000.0 ** (k + 1) for k, u in enumerate("KMGT")},
              **{u + "i": 1024.0 ** (k + 1) for k, u in enumerate("KMGT")}}
    return float(number) * powers[unit]


class Overlay:
    def __init__(self, name, manifests):
        self.name, self.manifests = name, manifests

    def of(self, *kinds):
        return [m for m in self.manifests if m["kind"] in kinds]

    def find(self, kind, name):
        return next((m for m in self.of(kind) if m["metadata"]["name"] == name), None)

    def config(self, name):
        """Data of the ConfigMap of that name, which kustomize gives a hash at its end."""
        found = [m for m in self.of("ConfigMap") if re.fullmatch(rf"{name}(-[a-z0-9]{{10}})?", m["metadata"]["name"])]
        return found[0]["data"] if len(found) == 1 else {}

    def pods(self):
        """(name, metadata, spec) of each workload's pods."""
        for m in self.of(*WORKLOADS):
            template = m["spec"]["template"]
            yield f"{m['kind']}/{m['metadata']['name']}", template["metadata"], template["spec"]

    def environment(self, container):
        """A container's variables, as Kubernetes would set them; secrets are "secret"."""
        values = {}
        for source in container.get("envFrom", []):
            values.update((self.find("ConfigMap", source["configMapRef"]["name"]) or {"data": {}})["data"])
        for variable in container.get("env", []):
            source = variable.get("valueFrom", {})
            if "configMapKeyRef" in source:
                reference = source["configMapKeyRef"]
                value = (self.find("ConfigMap", reference["name"]) or {"data": {}})["data"].get(reference["key"], "")
            elif "resourceFieldRef" in source:
                group, resource = source["resourceFieldRef"]["resource"].split(".")
                value = str(max(1, round(quantity(container["resources"][group][resource]))))
            else:
                value = "secret" if source else variable["value"]
            values[variable["name"]] = value
        return values


def selects(selector, labels):
    return all(labels.get(key) == value for key, value in selector.items())


def unique_names(overlay):
    seen, errors = set(), []
    for m in overlay.manifests:
        key = (m["kind"], m["metadata"]["name"])
        if key in seen:
            errors.append(f"{key[0]}/{key[1]} is there twice")
        seen.add(key)
    return errors


def restricted(overlay):
    """Pod Security Standard "restricted", and what goes beyond it here."""
    errors = []
    for name, _, pod in overlay.pods():
        context = pod.get("securityContext", {})
        wanted = {
            "runAsNonRoot": context.get("runAsNonRoot") is True,
            "runAsUser above 0": context.get("runAsUser", 0) > 0,
            "seccompProfile RuntimeDefault": context.get("seccompProfile", {}).get("type") == "RuntimeDefault",
            "automountServiceAccountToken false": pod.get("automountServiceAccountToken") is False,
            "enableServiceLinks false": pod.get("enableServiceLinks") is False,
            "no host namespaces": not any(pod.get(f) for f in ("hostNetwork", "hostPID", "hostIPC")),
            "no volumes of the host": not any("hostPath" in v for v in pod.get("volumes", [])),
        }
        for container in pod["containers"] + pod.get("initContainers", []):
            own = container.get("securityContext", {})
            wanted.update({
                f"{container['name']}: allowPrivilegeEscalation false": own.get("allowPrivilegeEscalation") is False,
                f"{container['name']}: readOnlyRootFilesystem": own.get("readOnlyRootFilesystem") is True,
                f"{container['name']}: drop ALL": own.get("capabilities") == {"drop": ["ALL"]},
                f"{container['name']}: nothing weaker than the pod's":
                    not {"runAsNonRoot", "runAsUser", "seccompProfile", "privileged"} & own.keys(),
                f"{container['name']}: requests and limits of cpu and memory":
                    all(r in container.get("resources", {}).get(g, {}) for g in ("requests", "limits") for r in ("cpu", "memory")),
            })
        errors += [f"{name}: wanted {what}" for what, is_so in wanted.items() if not is_so]
    return errors


def images(overlay):
    errors = []
    for name, _, pod in overlay.pods():
        for container in pod["containers"] + pod.get("initContainers", []):
            image, _, tag = container["image"].partition(":")
            if not tag or tag == "latest":
                errors.append(f"{name}: image {container['image']} has no tag of a version")
            if re.match(r"[^/]*[.:][^/]*/|localhost/", image):
                errors.append(f"{name}: image {container['image']} names a registry, which is for kustomization.yaml's `images`")
    return errors


def references(overlay):
    """What pods name is there."""
    errors = []
    for name, _, pod in overlay.pods():
        claims = {c["metadata"]["name"] for m in overlay.of("StatefulSet") if name.endswith("/" + m["metadata"]["name"])
                  for c in m["spec"].get("volumeClaimTemplates", [])}
        wanted = [("ServiceAccount", pod.get("serviceAccountName"))]
        for volume in pod.get("volumes", []):
            wanted += [("ConfigMap", volume.get("configMap", {}).get("name")),
                       ("Secret", volume.get("secret", {}).get("secretName")),
                       ("PersistentVolumeClaim", volume.get("persistentVolumeClaim", {}).get("claimName"))]
        for container in pod["containers"]:
            wanted += [("ConfigMap", e["configMapRef"]["name"]) for e in container.get("envFrom", [])]
            for variable in container.get("env", []):
                source = variable.get("valueFrom", {})
                wanted += [("ConfigMap", source.get("configMapKeyRef", {}).get("name")),
                           ("Secret", source.get("secretKeyRef", {}).get("name"))]
            mounts = {m["name"] for m in container.get("volumeMounts", [])}
            volumes = {v["name"] for v in pod.get("volumes", [])} | claims
            errors += [f"{name}: {v} is mounted, and no volume" for v in sorted(mounts - volumes)]
            errors += [f"{name}: volume {v} is not mounted" for v in sorted(volumes - mounts)]
            if not any(m["mountPath"] == "/tmp" for m in container.get("volumeMounts", [])):
                errors.append(f"{name}: {container['name']} has no /tmp to write to")
        for kind, wanted_name in wanted:
            is_outside = kind == "Secret" and wanted_name in OUTSIDE_SECRETS
            if wanted_name and not is_outside and overlay.find(kind, wanted_name) is None:
                errors.append(f"{name}: there is no {kind} {wanted_name}")
    if overlay.of("Secret"):
        errors.append("a Secret is contained")
    return errors


def container_ports(pod):
    return {p["name"]: p["containerPort"] for c in pod["containers"] for p in c.get("ports", [])}


def selectors(overlay):
    """Every selector finds pods or Services, every port is one of theirs."""
    errors = []
    pods = [(name, meta["labels"], container_ports(spec)) for name, meta, spec in overlay.pods()]

    def found(selector, ports, who):
        chosen = [p for p in pods if selector and selects(selector, p[1])]
        if not chosen:
            errors.append(f"{who}: selects no pod")
        for name, _, known in chosen:
            errors.extend(f"{who}: {name} has no port {p}" for p in ports if p not in known and p not in known.values())

    for m in overlay.of("Deployment", "StatefulSet"):
        who = f"{m['kind']}/{m['metadata']['name']}"
        if not selects(m["spec"]["selector"]["matchLabels"], m["spec"]["template"]["metadata"]["labels"]):
            errors.append(f"{who}: its selector does not match its pods")
        for spread in m["spec"]["template"]["spec"].get("topologySpreadConstraints", []):
            if not selects(spread["labelSelector"]["matchLabels"], m["spec"]["template"]["metadata"]["labels"]):
                errors.append(f"{who}: spreads pods that are not its own")
    for m in overlay.of("StatefulSet"):
        service = overlay.find("Service", m["spec"]["serviceName"])
        if service is None or service["spec"].get("clusterIP") != "None":
            errors.append(f"StatefulSet/{m['metadata']['name']}: {m['spec']['serviceName']} is no headless Service")
    for m in overlay.of("Service"):
        found(m["spec"]["selector"], [p["targetPort"] for p in m["spec"]["ports"]], f"Service/{m['metadata']['name']}")
    for m in overlay.of("PodDisruptionBudget"):
        found(m["spec"]["selector"]["matchLabels"], [], f"PodDisruptionBudget/{m['metadata']['name']}")
    for m in overlay.of("NetworkPolicy"):
        rules = m["spec"].get("ingress") or []
        found(m["spec"]["podSelector"]["matchLabels"], [p["port"] for r in rules for p in r["ports"]],
              f"NetworkPolicy/{m['metadata']['name']}")
    for m in overlay.of("HorizontalPodAutoscaler"):
        target = m["spec"]["scaleTargetRef"]
        scaled = overlay.find(target["kind"], target["name"])
        if scaled is None or "replicas" in scaled["spec"]:
            errors.append(f"HorizontalPodAutoscaler/{m['metadata']['name']}: scales nothing, or what has a number of replicas")
    for m in overlay.of("ServiceMonitor"):
        services = [s for s in overlay.of("Service") if selects(m["spec"]["selector"]["matchLabels"], s["metadata"]["labels"])]
        for endpoint in m["spec"]["endpoints"]:
            with_port = [s for s in services if endpoint["port"] in [p["name"] for p in s["spec"]["ports"]]]
            if len(with_port) != 1:
                errors.append(f"ServiceMonitor/{m['metadata']['name']}: {len(with_port)} Services have a port {endpoint['port']}")
    return errors


def isolation(overlay):
    """All pods may be called, and may call, only as policies say; health is for nodes alone."""
    errors = []
    for name, meta, _ in overlay.pods():
        policies = [m for m in overlay.of("NetworkPolicy") if selects(m["spec"]["podSelector"]["matchLabels"], meta["labels"])]
        types = {t for m in policies for t in m["spec"]["policyTypes"]}
        errors += [f"{name}: no policy of its {t}" for t in ("Ingress", "Egress") if t not in types]
        for m in policies:
            for rule in (m["spec"].get("ingress") or []) + (m["spec"].get("egress") or []):
                if not (rule.get("from") or rule.get("to")) or not rule.get("ports"):
                    errors.append(f"{name}: NetworkPolicy/{m['metadata']['name']} opens all ports, or to everybody")
    return errors


def probes(overlay):
    errors = []
    for name, _, pod in overlay.pods():
        if name.startswith("Job/"):
            continue
        for container in pod["containers"]:
            ports = container_ports(pod)
            for probe in ("startupProbe", "livenessProbe", "readinessProbe"):
                if probe not in container:
                    if probe != "startupProbe" or "grpc" in container.get("livenessProbe", {}):
                        errors.append(f"{name}: no {probe}")
                    continue
                port = container[probe].get("grpc", container[probe].get("tcpSocket", {})).get("port")
                if port not in ports and port not in ports.values():
                    errors.append(f"{name}: {probe} asks at {port}, which is no port")
    return errors


def jobs(overlay):
    errors = []
    for m in overlay.of("Job"):
        spec, pod = m["spec"], m["spec"]["template"]["spec"]
        who = f"Job/{m['metadata']['name']}"
        if pod.get("restartPolicy") != "Never":
            errors.append(f"{who}: podFailurePolicy needs restartPolicy Never")
        errors += [f"{who}: no {f}" for f in ("backoffLimit", "activeDeadlineSeconds", "podFailurePolicy") if f not in spec]
        for rule in spec.get("podFailurePolicy", {}).get("rules", []):
            codes = rule.get("onExitCodes")
            if rule["action"] not in ("FailJob", "Ignore", "Count") or (codes is None) == ("onPodConditions" not in rule):
                errors.append(f"{who}: a rule of podFailurePolicy is none")
            if codes and (codes["operator"] not in ("In", "NotIn") or
                          codes["containerName"] not in [c["name"] for c in pod["containers"]]):
                errors.append(f"{who}: a rule of podFailurePolicy names no container or operator")
    return errors


def as_the_image(overlay, dockerfile):
    """What pods take for granted of our images is so in the Dockerfile."""
    server = re.search(r'^ENTRYPOINT \["(\S+)"\]', dockerfile, re.M).group(1)
    user = int(re.search(r"^USER (\d+)", dockerfile, re.M).group(1))
    errors = []
    for name, _, pod in overlay.pods():
        for container in (c for c in pod["containers"] if c["image"].startswith("cagefit")):
            program = container.get("command", [server])[0]
            if program not in dockerfile or not program.endswith("/cagefit" if container["name"] == "fit" else "/cagefitd"):
                errors.append(f"{name}: starts {program}")
            if pod["securityContext"]["runAsUser"] != user:
                errors.append(f"{name}: runs as another user than the image's {user}")
            if overlay.environment(container).get("TMPDIR") != "/tmp":
                errors.append(f"{name}: TMPDIR is the image's, which is another volume")
    return errors


RULES = [unique_names, restricted, images, references, selectors, isolation, probes, jobs]


def same_pod(single, scaled):
    """The servers' pods of both overlays, but for what they keep sessions in, are one."""
    def common(overlay, kind):
        pod = copy.deepcopy(overlay.find(kind, "cagefitd")["spec"]["template"])
        spec = pod["spec"]
        for field in ("terminationGracePeriodSeconds", "topologySpreadConstraints"):
            spec.pop(field, None)
        spec["volumes"] = [v for v in spec["volumes"] if v["name"] not in ("sessions", "postgres")]
        container = spec["containers"][0]
        container["env"] = [e for e in container["env"] if not e["name"].startswith("PG")]
        container["volumeMounts"] = [m for m in container["volumeMounts"] if m["name"] not in ("sessions", "postgres")]
        container["envFrom"] = len(container["envFrom"])  # names differ by their hash
        return pod
    is_same = common(single, "StatefulSet") == common(scaled, "Deployment")
    return [] if is_same else ["single and scaled: the pods differ in more than their store"]
