#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Every verb's JSON is valid against docs/weft.schema.json, and verbs that fail print none.

usage: test_json_schema.py WEFT SCHEMA
"""
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile

try:
    import jsonschema
except ImportError:
    print("skipped: no python3-jsonschema")
    sys.exit(77)

SIZE = ["--size", "12x12"]
MAKE = [
    "make ramp --size 12 -o r.vdb --json",
    "make chirp --size 12 -o r.nrrd --json",
    "info r.nrrd --json",
    "make marschner-lobb --size 12 -o ml.vdb --json=made.json",
]
CPU = [
    "info ml.vdb --json",
    "convert ml.vdb ml.nrrd --json",
    "convert r.vdb r2.vdb --json --threads 2",
    "info ml.nrrd --json",
    "slice ml.vdb --engine cpu --size 12x12 -o f%d.exr --preview f%d.png --frames 1-3 --at 2..8 --json",
    "slice ml.vdb --engine cpu --size 12x12 -o s.exr --preview s.png --verify --error-image d.png --json",
    "slice ml.vdb --engine cpu --size 12x12 --quantity gradient,hessian --verify --json",
    "slice ml.vdb --explain --json",
    "slice ml.vdb --size 8x8 --profile unorm8 --explain --json",
    "info s.exr --json",
    "info s.png --json",
    "probe ml.vdb --points points.csv --json --verify --threads 1",
    "probe ml.vdb --points points.csv -o probed.csv --json",
    "probe ml.vdb --points points.csv -o probed.json",
    "probe ml.vdb --points points.csv --explain --json",
    "lattice ml.vdb --scale 1.5 -o l.vdb --verify --json -j 1",
    "lattice ml.vdb --scale 1.5 --explain --json",
    "resample s.exr --engine cpu --size 7x7 -o t.exr --verify --json",
    "resample s.exr --emulate --profile unorm8 --size 17x17 --kernel linear --verify --json",
    "resample s.exr --engine cpu --rotate 30 -o t.tif --json",
    "resample s.exr --explain --size 7x7 --json",
    "accumulate f1.exr f2.exr f3.exr -o m.exr --stderr e.exr --resume state --json",
    "accumulate f%d.exr --method tree --bits 8 --emulate --frames 1-3 -o m.exr --until 1 --json",
    "accumulate f%d.exr --frames 1-3 --explain --json",
    "effect antialias --frames 4 --explain --json",
    "antialias acaa --size 8x8 --samples 4 --explain --json",
    "kernel mitchell --json",
    "kernel linear catmull-rom --json",
    "kernel --list --json",
    "table --dims 1 --resolutions 4 --statistics --format json",
    "table --dims 1 --target-error 0.1 --bits 8 -o t.json",
    "plan --kernel linear --json=plan.json",
    "plan --kernel catmull-rom --profile unorm8 --json",
    "validate plan.json --json",
    "validate --kernel linear --dims 2 --order '0,0 1,0 0,1 1,1' --json",
    "stability --list --json",
]
GL = [
    "slice ml.vdb --size 12x12 -o s.exr --verify --json",
    "slice ml.vdb --size 12x12 --max-error 0.1 --verify --json",
    "slice ml.vdb --size 8x8 --profile unorm8 --kernel linear --verify --json",
    "slice ml.vdb --size 12x12 -o f%d.exr --frames 1-2 --at 2..8 --verify --json",
    "resample s.exr --size 7x7 -o t.exr --engine gl --verify --json",
    "effect antialias+motion-blur --size 8x8 --frames 4 -o fx.exr --preview fx.png --json",
    "effect soft-shadow --size 8x8 --frames 4 --until 1 --stderr se.exr -o fx.tif --json",
    "antialias acaa --size 8x8 --scene polygons:3,9 --samples 4 -o aa.exr --verify --json",
    "info fx.tif --json",
    "antialias msaa --size 8x8 --scene polygons:3,9 -o aa.tiff --type half --json",
    "antialias adaptive --size 8x8 --scene polygons:3,9 --verify --frames 2 -o aa%d.exr --json",
    "chart ramp --truth --quick --size 8x8 --kernel linear --csv c.csv --json",
    "chart --accumulate --quick --size 8x8 --frames 4 --json=chart.json",
    "chart --antialias --quick --size 8x8 --scene polygons:3,9 --json -q",
    "stability --case not-finite --json",
]
FAILURES = [
    "make nothing -o x.vdb --json",
    "info missing --json",
    "convert missing.vdb out.vdb --json",
    "slice missing.vdb --json",
    "slice ml.vdb --grid nothing --json",
    "slice ml.vdb -o /nowhere/s.exr --json",
    "slice missing%d.vdb --frames 0-1 -o q%d.exr --json",
    "probe ml.vdb --points missing.csv --json",
    "lattice missing.vdb --scale 2 --json",
    "resample missing.exr --size 2x2 --json",
    "accumulate missing.exr -o m.exr --json",
    "effect nothing --json",
    "effect antialias -o a.tif --compression piz --json",
    "antialias nothing --json",
    "probe ml.vdb --points points.csv -o a.json --json",
    "kernel nothing --json",
    "table --dims 9 --format json",
    "plan --kernel nothing --json",
    "validate missing.json --json",
    "chart missing.vdb --json",
    "stability --case nothing --json",
    "calibrate -o /nowhere/c --json",
]


def refuse(number):
    raise ValueError(number + " is not JSON")


class Checks:
    def __init__(self, weft, schema):
        self.weft, self.failed, self.seen = weft, 0, set()
        with open(schema, encoding="utf-8") as file:
            text = json.load(file)
        kind = getattr(jsonschema, "Draft202012Validator")
        kind.check_schema(text)
        self.validator = kind(text)

    def say(self, line, what):
        print(f"weft {line}: {what}")
        self.failed += 1

    def run(self, line):
        return subprocess.run([self.weft] + shlex.split(line), capture_output=True, text=True,
                              stdin=subprocess.DEVNULL, check=False)

    def document(self, line, result):
        """The text of the report, which is in a file where the line says so."""
        file = re.search(r"--json=(\S+)|(?:table|probe) .* -o (\S+\.json)", line)
        if not file:
            return result.stdout
        if result.stdout and "--json=" in line and line.split()[0] != "chart":
            self.say(line, "prints beside the file")
        with open(file.group(1) or file.group(2), encoding="utf-8") as report:
            return report.read()

    def valid(self, line):
        result = self.run(line)
        verb = line.split()[0]
        self.seen.add(verb)
        if result.returncode not in (0, 1):
            return self.say(line, f"code {result.returncode}: {result.stderr.strip()}")
        try:
            root = json.loads(self.document(line, result), parse_constant=refuse)
        except ValueError as error:
            return self.say(line, f"no JSON: {error}; {result.stderr.strip()}")
        for error in self.validator.iter_errors(root):
            self.say(line, f"{'.'.join(map(str, error.absolute_path))}: {error.message[:200]}")
        if root.get("verb") != verb:
            self.say(line, f"verb is {root.get('verb')}")
        self.files(line, root)
        error, bound = root.get("error"), root.get("bound")
        if error and bound is not None and error["max"] > bound:
            self.say(line, f"error {error['max']} is beyond the bound {bound}")
        return None

    def files(self, line, root):
        """Outputs are the files that are named, and inputs as they are named."""
        if list(root)[:9] != ["weft", "verb", "input", "output", "context", "seconds", "bytes",
                              "error", "bound"]:
            self.say(line, f"begins with {list(root)[:9]}")
        for file in root["output"]:
            if not os.path.exists(file["path"]) or file["bytes"] != os.path.getsize(file["path"]):
                self.say(line, f"output {file} is not there, or not of this size")
        words = shlex.split(line)
        for option in ("-o", "--preview", "--stderr", "--error-image"):
            if option in words and "--explain" not in words and not line.endswith(".json"):
                name = words[words.index(option) + 1].replace("%d", "[0-9]+")
                if not any(re.fullmatch(name, file["path"]) for file in root["output"]):
                    self.say(line, f"{name} is no output: {root['output']}")
        if words[0] not in ("make", "kernel", "effect", "antialias", "chart") and len(words) > 1 and \
                words[1][0] != "-" and root["input"][:1] != [words[1]]:
            self.say(line, f"input is {root['input']}")

    def fails(self, line):
        result = self.run(line)
        if result.returncode == 0 or result.stdout or not result.stderr:
            self.say(line, f"code {result.returncode}, prints {result.stdout[:80]!r}")

    def all_verbs_seen(self):
        verbs = self.validator.schema["properties"]["verb"]["enum"]
        for verb in set(verbs) - self.seen - {"calibrate"}:
            self.say(verb, "is not tested")
        for verb in verbs:
            text = self.run(f"help {verb} all").stdout
            if verb != "table" and "--json[=FILE]" not in text:
                self.say(verb, "has no --json")


def main():
    checks = Checks(os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]))
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        with open("points.csv", "w", encoding="utf-8") as file:
            file.write("x,y,z\n1.5,2,3\n4,5.25,6\n")
        for line in MAKE + CPU:
            checks.valid(line)
        has_gl = checks.run("slice ml.vdb --size 4x4 --engine gl --json").returncode != 5
        for line in GL if has_gl else []:
            checks.valid(line)
        for line in FAILURES:
            checks.fails(line)
        os.chdir("/")
    if has_gl:
        checks.all_verbs_seen()
    print(f"{checks.failed} failures")
    return 1 if checks.failed else 0


sys.exit(main())
