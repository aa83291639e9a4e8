#!/usr/bin/env python3
"""Plants bugs, one at a time, and looks whether the tests find them.

    tests/planted/run.py [--build DIR] [--jobs N] [--programs NAME...] [--] [TITLE-PART...]
    tests/planted/run.py --check     only whether each bug can still be planted in the sources as they are here

Works on a copy of the committed sources, in build-planted, so nothing here is touched. Each bug of bugs.txt is built
into the libraries, and golden_tests, unit_tests, fuzz_tests and the property tests are linked and run one after the
other until one of them fails, without the real meshes. Takes half a minute for most bugs and four minutes for one that
is not found; the tests are built first, once. Prints for each bug the test that found it. Exit code 0: every one was
found.
"""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
# The quick ones first.
PROGRAMS = ("golden_tests", "unit_tests", "fuzz_tests", "cut_property_tests", "session_property_tests",
            "build_property_tests", "out_of_memory_test")
LONGEST = 900  # seconds a program may take: a bug may make it run for ever


def read_bugs(text):
    bugs = []
    for part in text.split("\n== ")[1:]:
        title, file, *lines = part.splitlines()
        old = [line[2:] for line in lines if line.startswith("-")]
        new = [line[2:] for line in lines if line.startswith("+")]
        bugs.append((title, file, "".join(f"{line}\n" for line in old), "".join(f"{line}\n" for line in new)))
    return bugs


def run(*command, **options):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
                          **options)


def failed_test(output):
    """The last test that Catch2 gave a heading to: it names only those that fail."""
    headings = re.findall(r"^-{79}\n(.+)\n(?:  .+\n)*-{79}$", output, re.MULTILINE)
    return headings[-1] if headings else "?"


def found_by(build, programs, environment, jobs):
    """The first test that fails, and what its program says; None when none does."""
    for program in programs:
        made = run("cmake", "--build", build, "--parallel", str(jobs), "--target", program, env=environment)
        if made.returncode != 0:
            return "the compiler", made.stdout[-2000:]
        try:
            tried = run(str(build / program), "--abort", timeout=LONGEST, env=environment)
        except subprocess.TimeoutExpired:
            return f"{program}: no end", ""
        if tried.returncode != 0:
            return f"{program.removesuffix('_tests')}: {failed_test(tried.stdout)}", tried.stdout[-2000:]
    return None


def check_place(title, file, text, old):
    if text.count(old) != 1:
        sys.exit(f"{title}: the lines to be taken out stand {text.count(old)} times in {file}, not once")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build-planted", metavar="DIR")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), metavar="N", help="compilers at a time")
    parser.add_argument("--programs", nargs="+", default=PROGRAMS, choices=PROGRAMS, help="look with these alone")
    parser.add_argument("--check", action="store_true", help="only whether each bug can still be planted")
    parser.add_argument("titles", nargs="*", metavar="TITLE-PART", help="only bugs with one of these in their titles")
    arguments = parser.parse_args()

    bugs = [bug for bug in read_bugs((HERE / "bugs.txt").read_text())
            if not arguments.titles or any(part in bug[0] for part in arguments.titles)]
    if arguments.check:
        for title, file, old, _ in bugs:
            check_place(title, file, (ROOT / file).read_text(), old)
        return 0
    source = arguments.build.resolve() / "source"
    build = source / "build"
    if not source.exists():
        subprocess.run(["git", "clone", "--quiet", "--shared", ROOT, source], check=True)
    subprocess.run(["git", "-C", source, "fetch", "--quiet", ROOT, "HEAD"], check=True)
    subprocess.run(["git", "-C", source, "checkout", "--quiet", "--force", "FETCH_HEAD"], check=True)
    environment = {**os.environ, "PTET_DATA": "/nonexistent", "CCACHE_BASEDIR": str(source), "CCACHE_NOHASHDIR": "1"}
    launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
    subprocess.run(["cmake", "-S", source, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                    "-DPTET_BUILD_TOOLS=ON", "-DPTET_BUILD_EXAMPLES=OFF", "-DPTET_PYTHON=OFF",
                    "-DCMAKE_UNITY_BUILD=OFF", *launcher],
                   check=True, stdout=subprocess.DEVNULL)
    without = found_by(build, arguments.programs, environment, arguments.jobs)
    if without is not None:
        sys.exit(f"the tests fail without any bug: {without[0]}\n{without[1]}")

    missed = []
    for title, file, old, new in bugs:
        path = source / file
        text = path.read_text()
        check_place(title, file, text, old)
        start = time.monotonic()
        path.write_text(text.replace(old, new))
        by = found_by(build, arguments.programs, environment, arguments.jobs)
        path.write_text(text)
        if by is None:
            missed.append(title)
        elif by[0] == "the compiler":
            sys.exit(f"{title}: does not compile\n{by[1]}")
        print(f"{time.monotonic() - start:4.0f} s  {title}\n        {by[0] if by else 'NOT FOUND'}", flush=True)
    print(f"{len(bugs) - len(missed)} of {len(bugs)} found")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
