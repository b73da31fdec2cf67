#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""README, docs, scripts, help and completion name the same options.

usage: test_option_names.py WEFT SOURCE_DIR

What is written after `weft VERB` in README.md, docs/*.md and tools/*.sh is an option of that verb, what is
written as `--option` alone is one of some verb, and each verb's help has the options that its
completion has.
"""
import glob
import os
import re
import subprocess
import sys

# Of the program itself, and of the programs that pages are about.
OWN = {"--help", "--version", "--completion", "--man", "--all"}
OTHERS = {"--install", "--build", "--target", "--prefix", "--bench", "--static", "--libs", "--cflags",
          "--allow-run-as-root", "--oversubscribe", "--bind-to", "--mca", "--factor"}
MPI_VERBS = r"(?:mpirun|mpiexec)[^|;&`]*? weft"


def run(*arguments):
    return subprocess.run(arguments, capture_output=True, text=True, check=True).stdout


def read_options(weft):
    """{verb: options} by the completion, and by the help."""
    completed, verb = {}, None
    for line in run(weft, "help", "--completion", "bash").splitlines():
        case = re.match(r"    ([a-z]+)\)$", line)
        verb = case.group(1) if case else verb
        names = re.match(r"        names='([^']*)'", line)
        if names and verb:
            completed[verb] = set(names.group(1).split())
    helped = {}
    for verb in completed:
        text = run(weft, "help", verb, "all")
        helped[verb] = set(re.findall(r"^ +(?:-\w, )?(--[a-z0-9-]+)", text, re.M)) | {"--help"}
    return completed, helped


def commands(text):
    """(line number, command) of code blocks and of inline code, continued lines joined."""
    text = re.sub(r"\\\n", lambda match: " ", text)
    for number, line in enumerate(text.split("\n"), 1):
        spans = re.findall(r"`([^`]+)`", line)
        for span in spans or [line]:
            yield number, span


def is_start(option, options):
    """Whether getopt_long takes it: a name, or the start of one alone."""
    return option in options or sum(name.startswith(option) for name in options) == 1


def check_page(path, options, every, say):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    for number, command in commands(text):
        command = command.split(" #")[0]
        for part in re.split(r"[|;]|&&", command):
            found = re.match(r"\s*(?:\$ )?(?:[A-Z_]+=\S* )*(?:" + MPI_VERBS + r'|"?\$?weft"?) ([a-z]+)\b(.*)',
                             part)
            words = re.findall(r"(?<![\w-])(--[a-z][a-z0-9-]*)", part)
            if found and found.group(1) in options:
                verb = found.group(1)
                words = re.findall(r"(?<![\w-])(--[a-z][a-z0-9-]*)", found.group(2))
                for word in words:
                    if not is_start(word, options[verb]):
                        say(f"{path}:{number}: weft {verb} has no {word}")
            elif part.startswith("--"):
                for word in words[:1]:
                    if word not in every and word not in OWN | OTHERS:
                        say(f"{path}:{number}: no verb has {word}")


def main():
    weft, source = sys.argv[1], sys.argv[2]
    failures = []
    completed, helped = read_options(weft)
    if len(completed) < 17:
        failures.append(f"the completion has {len(completed)} verbs")
    for verb, names in completed.items():
        for name in names ^ helped[verb]:
            failures.append(f"{name} of weft {verb} is in one of help and completion")
    every = set().union(*completed.values())
    pages = [os.path.join(source, "README.md")]
    for names in ("docs/*.md", "tools/*.sh"):
        pages += sorted(glob.glob(os.path.join(source, names)))
    for page in pages:
        check_page(page, completed, every, failures.append)
    print("\n".join(failures + [f"{len(pages)} pages, {len(every)} options, {len(failures)} failures"]))
    return 1 if failures else 0


sys.exit(main())
