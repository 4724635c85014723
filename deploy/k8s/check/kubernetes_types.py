"""Kubernetes' own types, read out of kubectl: a Go program holds the descriptors of all protobuf messages that it is linked
with, and those of Kubernetes have the names and types of all fields of all kinds. Works for kubectl 1.20 (Debian 12) to 1.33."""
import re
import zlib

from google.protobuf import descriptor_pb2
from google.protobuf.message import DecodeError

FIELD = descriptor_pb2.FieldDescriptorProto
QUANTITY = re.compile(r"[+-]?[0-9.]+([eE][+-]?[0-9]+|[numkMGTPE]|[KMGTPE]i)?")
DURATION = re.compile(r"([0-9]+(ms|[smhdwy]))+")

# Of an older kubectl, the messages that have the same fields as these.
OLDER = {"k8s.io.api.autoscaling.v2": "k8s.io.api.autoscaling.v2beta2", "k8s.io.api.policy.v1": "k8s.io.api.policy.v1beta1"}
# Fields that Go embeds: what they hold stands one level higher in JSON.
EMBEDDED = {"handler", "volumeSource", "localObjectReference", "ephemeralContainerCommon", "persistentVolumeSource"}

# Shapes of what kubectl does not know: {name: shape}, {"*": shape} for any names, [shape], or a leaf.
LABELS = {"*": str}
SELECTOR = {"matchLabels": LABELS, "matchExpressions": [{"key": str, "operator": str, "values": [str]}]}
NEWER = {  # than 1.20; a newer kubectl has them, and they are checked by what it says
    ("Handler", "grpc"): {"port": int, "service": str},
    ("JobSpec", "podFailurePolicy"): {"rules": [{
        "action": str, "onExitCodes": {"containerName": str, "operator": str, "values": [int]},
        "onPodConditions": [{"type": str, "status": str}]}]},
}
CUSTOM = {  # of the Prometheus operator, as far as they are used here
    "ServiceMonitor": {"jobLabel": str, "targetLabels": [str], "podTargetLabels": [str], "selector": SELECTOR,
                       "namespaceSelector": {"any": bool, "matchNames": [str]},
                       "endpoints": [{"port": str, "path": str, "scheme": str, "interval": DURATION,
                                      "scrapeTimeout": DURATION, "honorLabels": bool}]},
    "PrometheusRule": {"groups": [{"name": str, "interval": DURATION, "labels": LABELS, "rules": [{
        "alert": str, "record": str, "expr": str, "for": DURATION, "labels": LABELS, "annotations": LABELS}]}]},
}

# The descriptors do not tell these; those of what is used here.
REQUIRED = {
    "Container": ["name", "image"], "ContainerPort": ["containerPort"], "EnvVar": ["name"], "VolumeMount": ["name", "mountPath"],
    "Volume": ["name"], "ServicePort": ["port"], "GRPCAction": ["port"], "TCPSocketAction": ["port"],
    "DeploymentSpec": ["selector", "template"], "StatefulSetSpec": ["selector", "template", "serviceName"], "JobSpec": ["template"],
    "PodSpec": ["containers"], "NetworkPolicySpec": ["podSelector"], "KeyToPath": ["key", "path"], "SecretKeySelector": ["key"],
    "ConfigMapKeySelector": ["key"], "ResourceFieldSelector": ["resource"], "SeccompProfile": ["type"],
    "TopologySpreadConstraint": ["maxSkew", "topologyKey", "whenUnsatisfiable"], "CrossVersionObjectReference": ["kind", "name"],
    "HorizontalPodAutoscalerSpec": ["scaleTargetRef", "maxReplicas"], "MetricSpec": ["type"], "MetricIdentifier": ["name"],
    "MetricTarget": ["type"], "PodsMetricSource": ["metric", "target"], "HPAScalingPolicy": ["type", "value", "periodSeconds"],
    "PersistentVolumeClaimVolumeSource": ["claimName"], "PodFailurePolicyRule": ["action"],
}
PROTOCOLS = {"TCP", "UDP", "SCTP"}
VALUES = {
    ("Container", "imagePullPolicy"): {"Always", "IfNotPresent", "Never"},
    ("ContainerPort", "protocol"): PROTOCOLS,
    ("DeploymentStrategy", "type"): {"RollingUpdate", "Recreate"},
    ("HPAScalingPolicy", "type"): {"Pods", "Percent"},
    ("MetricSpec", "type"): {"Resource", "Pods", "Object", "External", "ContainerResource"},
    ("MetricTarget", "type"): {"Utilization", "Value", "AverageValue"},
    ("NetworkPolicyPort", "protocol"): PROTOCOLS,
    ("NetworkPolicySpec", "policyTypes"): {"Ingress", "Egress"},
    ("PersistentVolumeClaimSpec", "accessModes"): {"ReadWriteOnce", "ReadWriteOncePod", "ReadWriteMany", "ReadOnlyMany"},
    ("PodSecurityContext", "fsGroupChangePolicy"): {"Always", "OnRootMismatch"},
    ("PodSpec", "restartPolicy"): {"Always", "OnFailure", "Never"},
    ("SeccompProfile", "type"): {"RuntimeDefault", "Localhost"},
    ("ServicePort", "protocol"): PROTOCOLS,
    ("ServiceSpec", "type"): {"ClusterIP", "NodePort", "LoadBalancer"},
    ("TopologySpreadConstraint", "whenUnsatisfiable"): {"DoNotSchedule", "ScheduleAnyway"},
}


def read_descriptors(program):
    """Messages by full name, of all gzip streams in the program's file that hold the descriptor of a .proto file."""
    with open(program, "rb") as file:
        data = file.read()
    messages, at = {}, data.find(b"\x1f\x8b\x08")
    while at >= 0:
        try:
            text = zlib.decompressobj(31).decompress(data[at:at + (1 << 20)])
            proto = descriptor_pb2.FileDescriptorProto.FromString(text)
            for message in proto.message_type if proto.name.endswith(".proto") else []:
                messages[f"{proto.package}.{message.name}"] = message
        except (zlib.error, DecodeError):
            pass
        at = data.find(b"\x1f\x8b\x08", at + 3)
    return messages


def is_leaf(value, kind):
    if isinstance(kind, re.Pattern):
        return isinstance(value, str) and kind.fullmatch(value) is not None
    return isinstance(value, kind) and (kind is bool or not isinstance(value, bool))


def shape_errors(value, shape, where):
    if isinstance(shape, list):
        if not isinstance(value, list):
            return [f"{where}: expected a list"]
        return [e for k, item in enumerate(value) for e in shape_errors(item, shape[0], f"{where}[{k}]")]
    if not isinstance(shape, dict):
        return [] if is_leaf(value, shape) else [f"{where}: {value!r} has the wrong type"]
    if not isinstance(value, dict):
        return [f"{where}: expected fields"]
    errors = []
    for name, item in value.items():
        if name in shape or "*" in shape:
            errors += shape_errors(item, shape.get(name, shape.get("*")), f"{where}.{name}")
        else:
            errors.append(f"{where}: unknown field {name}")
    return errors


class KubernetesTypes:
    def __init__(self, kubectl):
        self._messages = read_descriptors(kubectl)
        if "k8s.io.api.core.v1.PodSpec" not in self._messages:
            raise SystemExit(f"check: {kubectl} holds no descriptors of Kubernetes' types; use a kubectl from 1.20 to 1.33")

    def errors(self, manifest):
        """What Kubernetes would not take of one manifest, one line each."""
        version, kind = manifest.get("apiVersion", ""), manifest.get("kind", "")
        fields = {name: value for name, value in manifest.items() if name not in ("apiVersion", "kind")}
        if version == "monitoring.coreos.com/v1" and kind in CUSTOM:
            meta = self._message_errors(fields.pop("metadata", {}), "k8s.io.apimachinery.pkg.apis.meta.v1.ObjectMeta", "metadata")
            return meta + shape_errors(fields, {"spec": CUSTOM[kind]}, kind)
        name = self._name_of(version, kind)
        return self._message_errors(fields, name, kind) if name else [f"unknown kind {version} {kind}"]

    def _name_of(self, version, kind):
        group, number = version.rsplit("/", 1) if "/" in version else ("core", version)
        package = f"k8s.io.api.{group.removesuffix('.k8s.io')}.{number}"
        names = (f"{p}.{kind}" for p in (package, OLDER.get(package)))
        return next((name for name in names if name in self._messages), None)

    def _fields(self, message):
        """Fields as JSON has them, and the message that each is of."""
        for field in message.field:
            if field.name in EMBEDDED and field.type == FIELD.TYPE_MESSAGE:
                yield from self._fields(self._messages[field.type_name[1:]])
            else:
                yield field, message.name

    def _message_errors(self, value, name, where):
        if not isinstance(value, dict):
            return [f"{where}: expected fields"]
        message = self._messages[name]
        known = {field.name: (field, owner) for field, owner in self._fields(message)}
        owners = {message.name} | {owner for _, owner in known.values()}
        errors = [f"{where}: {field} is missing" for field in REQUIRED.get(message.name, []) if field not in value]
        for field_name, item in value.items():
            newer = [NEWER[owner, field_name] for owner in owners if (owner, field_name) in NEWER]
            if field_name in known:
                errors += self._field_errors(item, *known[field_name], message, f"{where}.{field_name}")
            elif newer:
                errors += shape_errors(item, newer[0], f"{where}.{field_name}")
            elif "metadata" not in known or field_name not in ("apiVersion", "kind"):
                errors.append(f"{where}: unknown field {field_name}")
        return errors

    def _field_errors(self, value, field, owner, message, where):
        entry = next((m for m in message.nested_type if field.type_name.endswith(f".{m.name}") and m.options.map_entry), None)
        if entry is not None:
            if not isinstance(value, dict):
                return [f"{where}: expected fields"]
            return [e for key, item in value.items() for e in self._value_errors(item, entry.field[1], f"{where}.{key}")]
        allowed = VALUES.get((owner, field.name))
        if field.label != FIELD.LABEL_REPEATED:
            values = [value]
            errors = self._value_errors(value, field, where)
        elif not isinstance(value, list):
            return [f"{where}: expected a list"]
        else:
            values = value
            errors = [e for k, item in enumerate(value) for e in self._value_errors(item, field, f"{where}[{k}]")]
        if allowed and not errors:
            errors = [f"{where}: {v} is none of {', '.join(sorted(allowed))}" for v in values if v not in allowed]
        return errors

    def _value_errors(self, value, field, where):
        if field.type == FIELD.TYPE_MESSAGE:
            short = field.type_name.rsplit(".", 1)[1]
            if short == "Quantity":
                ok = is_leaf(value, int) or is_leaf(value, QUANTITY)
            elif short == "IntOrString":
                ok = is_leaf(value, int) or is_leaf(value, str)
            elif short in ("Time", "MicroTime"):
                ok = is_leaf(value, str)
            else:
                return self._message_errors(value, field.type_name[1:], where)
        elif field.type == FIELD.TYPE_BOOL:
            ok = is_leaf(value, bool)
        elif field.type in (FIELD.TYPE_STRING, FIELD.TYPE_BYTES):
            ok = is_leaf(value, str)
        else:
            ok = is_leaf(value, int)
        return [] if ok else [f"{where}: {value!r} has the wrong type"]
