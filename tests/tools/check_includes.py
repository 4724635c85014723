#!/usr/bin/env python3
"""Checks that folders include each other only in the directions that the design allows, and that a library is included
only where it has its one place. Usage: check_includes.py ROOT"""
import pathlib
import re
import sys

# Folder -> folders that it may include directly (itself always).
ALLOWED = {
    "core/base": [],
    "core/mesh": ["core/base"],
    "core/subdiv": ["core/base", "core/mesh"],
    "core/cloud": ["core/base", "core/mesh"],
    "core/image": ["core/base", "core/mesh", "core/cloud"],
    "core/codec": ["core/base", "core/mesh", "core/cloud", "core/image"],
    "core/template": ["core/base", "core/mesh", "core/subdiv", "core/cloud"],
    "core/energy": ["core/base", "core/mesh", "core/subdiv", "core/cloud", "core/image"],
    "core/metrics": ["core/base", "core/mesh", "core/subdiv", "core/cloud"],
    "core/fit": ["core/base", "core/mesh", "core/subdiv", "core/cloud", "core/image", "core/energy"],
}
CORE = sorted(ALLOWED)
ALLOWED["server/session"] = ["core/base", "core/mesh", "core/subdiv", "core/cloud", "core/image", "core/fit",
                             "core/codec", "core/metrics"]
ALLOWED["server/store"] = ["server/session"] + ALLOWED["server/session"]
ALLOWED["server/transport"] = ["server/session", "cagefit/v1"] + ALLOWED["server/session"]
ALLOWED["server"] = ["server/store", "server/transport"] + ALLOWED["server/transport"]
CLIENT_CORE = [f for f in CORE if f not in ("core/energy", "core/fit")]
ALLOWED["client/io"] = ["core/base", "core/mesh", "core/cloud", "core/image", "core/codec", "core/subdiv"]
ALLOWED["client/report"] = ["client/io"] + CLIENT_CORE
ALLOWED["client/synth"] = ["client/io"] + CLIENT_CORE
ALLOWED["client"] = ["client/io", "client/report", "client/synth", "client/commands", "cagefit/v1"] + CLIENT_CORE
ALLOWED["client/commands"] = ["client"] + ALLOWED["client"]
ALLOWED["deploy/manual"] = ["client/commands", "server"]
# The one file of the client that may know the server.
EMBEDDED = re.compile(r"client/embedded_server\.(h|cc)$")

# Library -> where it may be included.
LIBRARIES = {
    r"draco/": ["core/codec"],
    r"png\.h": ["core/codec"],
    r"nanoflann": ["core/cloud/kd_tree.cc"],
    r"open3d/": ["core/template", "client/io"],
    r"ceres/": ["core/fit"],
    r"CLI/": ["server/server_options", "client/commands", "client/main.cc", "deploy/manual"],
    r"(grpc|grpcpp|google/protobuf|google/rpc)/": ["server/transport", "server/server", "server/network", "server/main.cc",
                                                   "client/"],
    r"prometheus/": ["server/metrics_port.cc"],
    r"sqlite3": ["server/store"],
    r"spdlog/": ["server/"],
    r"cagefit/v1/": ["server/transport", "server/server", "server/main.cc", "client/"],
}
NOT_IN = {r"(grpc|grpcpp|google/protobuf|spdlog|cagefit/v1)/": ["server/session", "core/"]}


def folder_of(path):
    """The longest known folder that holds path."""
    known = [f for f in list(ALLOWED) + ["cagefit/v1"] if path.startswith(f + "/")]
    return max(known, key=len) if known else None


def main(root):
    errors = []
    files = [p for top in ("core", "server", "client", "deploy") for p in sorted((root / top).rglob("*")) if p.suffix in (".h", ".cc")]
    for file in files:
        name = file.relative_to(root).as_posix()
        folder = folder_of(name)
        if folder is None:
            errors.append(f"{name}: its folder is not in the list of the include check")
            continue
        for number, line in enumerate(file.read_text().splitlines(), 1):
            match = re.match(r'\s*#\s*include\s*[<"]([^">]+)[">]', line)
            if not match:
                continue
            included = match.group(1)
            at = f"{name}:{number}: includes {included}"
            target = folder_of(included)
            if target is not None and target != folder and target not in ALLOWED[folder]:
                if not (EMBEDDED.search(name) and target.startswith("server")):
                    errors.append(f"{at}: {folder} may not include {target}")
            for pattern, places in LIBRARIES.items():
                if re.match(pattern, included) and not any(name.startswith(p) for p in places):
                    errors.append(f"{at}: that library has its place in {', '.join(places)}")
            for pattern, places in NOT_IN.items():
                if re.match(pattern, included) and any(name.startswith(p) for p in places):
                    errors.append(f"{at}: not allowed here")
    print("\n".join(errors) or f"{len(files)} files, all includes in the allowed directions")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]).resolve()))
