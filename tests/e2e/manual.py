#!/usr/bin/env python3
"""manual.py MANUAL CAGEFIT CAGEFITD: every command has a page that mandoc takes without complaint and that names just the
options of its --help, and bash completes commands, options and values."""
import pathlib
import re
import subprocess
import sys

MANUAL = pathlib.Path(sys.argv[1])
PROGRAMS = {"cagefit": sys.argv[2], "cagefitd": sys.argv[3]}
errors = []


def output(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def options(text):
    """Those at the start of a line, where help and pages alike define them."""
    lines = [line.strip() for line in text.splitlines() if re.match(r"\s+-", line)]
    return {name for line in lines for name in re.findall(r"(?:^|,\s?)(--?[a-z][a-z-]*)", line.split("  ")[0])}


def subcommands(help_text):
    _, _, listed = help_text.partition("\nSubcommands:\n")
    return re.findall(r"^  (\w+) ", listed.split("\n\n")[0], re.MULTILINE)


def check_command(words):
    help_text = output(PROGRAMS[words[0]], *words[1:], "--help")
    section = 8 if words[0] == "cagefitd" else 1
    page = MANUAL / f"man/man{section}" / f"{'-'.join(words)}.{section}"
    lint = subprocess.run(["mandoc", "-T", "lint", "-W", "warning", page], capture_output=True, text=True).stdout
    errors.extend(line for line in lint.splitlines() if "missing date" not in line)
    text = re.sub(r".\x08", "", output("mandoc", "-T", "utf8", "-O", "width=200", page))
    for missing in sorted(options(help_text) - options(text)):
        errors.append(f"{page.name}: {missing} is not there")
    for unknown in sorted(options(text) - options(help_text)):
        errors.append(f"{page.name}: {unknown} is no option of it")
    pages = [page.name]
    for name in subcommands(help_text):
        pages += check_command(words + [name])
    return pages


def check_completion(words, expected):
    script = f"""
      source {MANUAL}/bash-completion/completions/{words[0]}
      COMP_WORDS=({' '.join(repr(word) for word in words)}); COMP_CWORD={len(words) - 1}; _{words[0]}
      echo "${{COMPREPLY[@]}}" """
    got = output("bash", "-c", script).split()
    if got != expected:
        errors.append(f"completion of {' '.join(words)}: {got}; expected {expected}")


pages = check_command(["cagefit"]) + check_command(["cagefitd"])
there = sorted(path.name for path in MANUAL.glob("man/*/*"))
if there != sorted(pages):
    errors.append(f"pages are {there}; expected {sorted(pages)}")
check_completion(["cagefit", "fi"], ["fit"])
check_completion(["cagefit", "session", "p"], ["pull"])
check_completion(["cagefit", "fit", "--form"], ["--format"])
check_completion(["cagefit", "fit", "capture", "--format", "g"], ["gltf"])
check_completion(["cagefit", "fit", "--out", ""], [])  # bash's own: names of files
check_completion(["cagefit", "fit", "cap"], [])
check_completion(["cagefitd", "--max-mem"], ["--max-memory"])
print("\n".join(errors) or f"{len(pages)} pages name every option")
sys.exit(1 if errors else 0)
