"""Puts the fit of many takes on an OpenCue farm: one layer, a frame of it for each chunk of the takes.

    python3 deploy/opencue/cagefit_job.py --show SHOW --shot SHOT OUT CAPTURE... [-- FIT OPTION...]

A frame that was killed or lost its host goes on, when it is retried, behind the last frame of the take that was answered.
"""
import argparse
import getpass
import os
import shlex
import sys

import outline
import outline.cuerun
import outline.modules.shell


def parse(words):
    at = words.index("--") if "--" in words else len(words)
    parser = argparse.ArgumentParser(usage="%(prog)s --show SHOW --shot SHOT [options] OUT CAPTURE... [-- FIT OPTION...]")
    parser.add_argument("out", metavar="OUT", help="folder for the takes, seen by all hosts; a relative path is made absolute")
    parser.add_argument("captures", metavar="CAPTURE", nargs="+", help="of a take: a folder of frames, or a file")
    parser.add_argument("--show", required=True)
    parser.add_argument("--shot", required=True)
    parser.add_argument("--name", default="cagefit", help="of the job")
    parser.add_argument("--chunks", type=int, help="frames of the layer; default: one for each take")
    parser.add_argument("--cores", type=int, default=4, help="of a frame")
    parser.add_argument("--memory", default="4g", help="of a frame, as in 4g or 512m")
    parser.add_argument("--retries", type=int, default=3, help="of a frame; Cuebot may allow fewer")
    parser.add_argument("--cagefit", default="cagefit", help="the program, as the hosts see it")
    parser.add_argument("--pause", action="store_true", help="launch the job paused")
    arguments = parser.parse_args(words[:at])
    arguments.chunks = len(arguments.captures) if arguments.chunks is None else arguments.chunks
    if arguments.chunks < 1 or arguments.cores < 1:
        parser.error("--chunks and --cores are at least 1")
    arguments.options = words[at + 1:]
    return arguments


def command_of(arguments):
    """The words of a frame's command; Cuebot puts the number of the frame in the place of #IFRAME#."""
    captures = [os.path.abspath(capture) for capture in arguments.captures]
    words = [arguments.cagefit, "fit", "--takes", *captures, "--out", os.path.abspath(arguments.out)]
    words += ["--chunk", f"#IFRAME#/{arguments.chunks}", *arguments.options]
    # The hosts' shells get them joined by blanks.
    return [shlex.quote(word) for word in words]


def job_of(arguments):
    job = outline.Outline(arguments.name, show=arguments.show, shot=arguments.shot, user=getpass.getuser())
    job.add_layer(outline.modules.shell.Shell(
        "fit_takes",
        command=command_of(arguments),
        range=f"0-{arguments.chunks - 1}",
        chunk=1,
        cores=arguments.cores,
        overrideCores=True,  # newer versions take `cores` only with it
        memory=arguments.memory,
        env={"CAGEFIT_THREADS": str(arguments.cores)}))
    return job


def main():
    arguments = parse(sys.argv[1:])
    # Without the wrapper pycuerun a host needs nothing but the program.
    outline.cuerun.launch(job_of(arguments), use_pycuerun=False, maxretries=arguments.retries, pause=arguments.pause)


if __name__ == "__main__":
    main()
