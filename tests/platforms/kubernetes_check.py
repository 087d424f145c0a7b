#!/usr/bin/env python3
"""kubernetes_check.py MANIFESTS: are the keys and types known, and does what refers to something meet it?

Complaints go to standard output, one a line; the exit code says whether there are any. With --named it prints what the
manifests name of the programs, for the test to look up: "flag PROGRAM --x", "path /x", "metric x".
"""
import pathlib
import re
import sys

import yaml

SCHEMA = yaml.safe_load((pathlib.Path(__file__).parent / "kubernetes_schema.yaml").read_text())
LEAVES = {
    "str": lambda v: isinstance(v, str) and v != "",
    "int": lambda v: isinstance(v, int) and not isinstance(v, bool),
    "bool": lambda v: isinstance(v, bool),
    "quantity": lambda v: re.fullmatch(r"\d+(\.\d+)?(m|k|Ki|M|Mi|G|Gi|T|Ti)?", str(v)),
    "share": lambda v: isinstance(v, int) or re.fullmatch(r"\d+%", str(v)),
    "port": lambda v: 0 < v < 65536 if isinstance(v, int) else re.fullmatch(r"[a-z0-9]([a-z0-9-]{0,13}[a-z0-9])?", v),
    "base64": lambda v: isinstance(v, str),
}


def check(value, shape, where):
    if isinstance(shape, str) and shape.startswith("$"):
        shape = SCHEMA[shape[1:]]
    if isinstance(shape, dict):
        if not isinstance(value, dict):
            yield f"{where}: a mapping is wanted, not {value!r}"
            return
        known = {key.rstrip("!"): key for key in shape}
        for key in (k for k in shape if k.endswith("!") and k[:-1] not in value):
            yield f"{where}: {key[:-1]} is missing"
        for key, inner in value.items():
            if key not in known and "*" not in known:
                yield f"{where}: unknown key '{key}'"
            else:
                yield from check(inner, shape[known.get(key, "*")], f"{where}.{key}")
    elif isinstance(shape, list):
        if not isinstance(value, list):
            yield f"{where}: a list is wanted, not {value!r}"
            return
        for i, inner in enumerate(value):
            yield from check(inner, shape[0], f"{where}[{i}]")
    elif not (LEAVES[shape](value) if shape in LEAVES else value in shape.split()):
        yield f"{where}: {value!r} is not of the kind '{shape}'"


def pods(documents):
    for d in documents:
        if d["kind"] in ("StatefulSet", "Deployment"):
            yield d, d["spec"]["template"]


def matches(selector, labels):
    return selector.items() <= labels.items()


def references(documents):
    """What one manifest says of another."""
    by_name = {(d["kind"], d["metadata"]["name"]): d for d in documents}
    labels = [pod["metadata"]["labels"] for _, pod in pods(documents)]
    ports = {p["name"]: p["containerPort"] for _, pod in pods(documents) for c in pod["spec"]["containers"] for p in c.get("ports", [])}
    for d, pod in pods(documents):
        where = f"{d['kind']} {d['metadata']['name']}"
        if not matches(d["spec"]["selector"]["matchLabels"], pod["metadata"]["labels"]):
            yield f"{where}: its selector does not find its own pods"
        volumes = {v["name"] for v in pod["spec"].get("volumes", [])}
        volumes |= {v["metadata"]["name"] for v in d["spec"].get("volumeClaimTemplates", [])}
        for volume in pod["spec"].get("volumes", []):
            if "secret" in volume and ("Secret", volume["secret"]["secretName"]) not in by_name:
                yield f"{where}: no secret {volume['secret']['secretName']}"
        for container in pod["spec"]["containers"]:
            mounts = container.get("volumeMounts", [])
            yield from (f"{where}: no volume {m['name']}" for m in mounts if m["name"] not in volumes)
            paths = [m["mountPath"] for m in mounts]
            for argument in container["args"] + [e["value"] for e in container.get("env", []) if "value" in e]:
                path = re.search(r"=?(/[\w./-]+)$", argument)
                if path and "://" not in argument and not any(path[1].startswith(p) for p in paths):
                    yield f"{where}: {argument}: the root is read-only and nothing is mounted there"
            own = {p["name"] for p in container.get("ports", [])}
            for probe in ("startupProbe", "readinessProbe", "livenessProbe"):
                port = container.get(probe, {}).get("httpGet", {}).get("port")
                if port is not None and port not in own:
                    yield f"{where}: {probe} asks port {port}, which is not there"
    for d in documents:
        where, spec = f"{d['kind']} {d['metadata']['name']}", d.get("spec", {})
        selectors = []
        if d["kind"] == "Service":
            selectors = [spec["selector"]]
            yield from (f"{where}: no port {p['targetPort']}" for p in spec["ports"] if ports.get(p["targetPort"]) != p["port"])
        if d["kind"] == "NetworkPolicy":
            selectors = [spec["podSelector"]["matchLabels"]]
            for rule in spec.get("ingress", []) + spec.get("egress", []):
                selectors += [p["podSelector"]["matchLabels"] for p in rule.get("from", []) + rule.get("to", []) if "podSelector" in p]
                named = [p["port"] for p in rule.get("ports", []) if isinstance(p["port"], str)]
                yield from (f"{where}: no port {name}" for name in named if name not in ports)
        if d["kind"] == "PodDisruptionBudget":
            selectors = [spec["selector"]["matchLabels"]]
        for selector in selectors:
            if not any(matches(selector, pod) for pod in labels):
                yield f"{where}: no pod has {selector}"
        for target in [spec.get("scaleTargetRef")] + [m["object"]["describedObject"] for m in spec.get("metrics", [])]:
            if target and (target["kind"], target["name"]) not in by_name:
                yield f"{where}: no {target['kind']} {target['name']}"
        if d["kind"] == "ServiceMonitor":
            services = [s for s in documents if s["kind"] == "Service" and matches(spec["selector"]["matchLabels"], s["metadata"]["labels"])]
            served = {p["name"] for s in services for p in s["spec"]["ports"]}
            yield from (f"{where}: no service has port {e['port']}" for e in spec["endpoints"] if e["port"] not in served)


def named(documents):
    for d, pod in pods(documents):
        for container in pod["spec"]["containers"]:
            program, *arguments = container["args"]
            for argument in arguments:
                flag, _, value = argument.partition("=")
                yield f"flag {program} {flag}"
                if flag == "--set":
                    yield f"key {value.partition('=')[0]}"
            for probe in ("startupProbe", "readinessProbe", "livenessProbe"):
                if "httpGet" in container.get(probe, {}):
                    yield f"path {container[probe]['httpGet']['path']}"
    for d in documents:
        for metric in d.get("spec", {}).get("metrics", []) if d["kind"] == "HorizontalPodAutoscaler" else []:
            yield f"metric {metric['object']['metric']['name']}"
        if d["kind"] == "ServiceMonitor":
            yield from (f"path {e['path']}" for e in d["spec"]["endpoints"])


def main():
    documents = [d for d in yaml.safe_load_all(open(sys.argv[-1], encoding="utf-8")) if d]
    if "--named" in sys.argv:
        print("\n".join(sorted(set(named(documents)))))
        return 0
    complaints = []
    for d in documents:
        kind = f"{d.pop('kind')} {d.pop('apiVersion')}"
        where = f"{kind} {d.get('metadata', {}).get('name')}"
        complaints += list(check(d, SCHEMA[kind], where)) if kind in SCHEMA else [f"{where}: unknown kind"]
        d["kind"] = kind.split()[0]
    complaints = complaints or list(references(documents))
    print("\n".join(complaints))
    return 1 if complaints else 0


sys.exit(main())
