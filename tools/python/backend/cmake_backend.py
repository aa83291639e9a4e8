"""Builds the package's wheel: configures and compiles with CMake, and packs what lies in <build>/python then.

A PEP 517 backend that needs nothing but Python's library, so that `pip install tools/python` works without a network.
What is compiled stays in build-python/ at the top of the repository, for the next time; the environment variable
PTET_BUILD_DIR names another folder, such as one where ptet is built already; a relative one is below the top of the
repository.
"""

import base64
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import zipfile

HERE = pathlib.Path(__file__).resolve().parents[1]
TOP = HERE.parents[1]


def get_requires_for_build_wheel(config_settings=None):
    return []


def get_requires_for_build_sdist(config_settings=None):
    return []


class UnsupportedOperation(Exception):
    """PEP 517's name for what a backend does not do."""


def build_sdist(sdist_directory, config_settings=None):
    raise UnsupportedOperation("the package is built from a clone of ptet's repository, whose library it holds")


def _run(*command):
    command = [str(part) for part in command]
    print("+", *command, flush=True)
    if subprocess.run(command, check=False).returncode != 0:
        raise SystemExit(f"{' '.join(command)} failed; tools/install-dependencies.sh --python installs what is needed")


def _build_folder():
    given = os.environ.get("PTET_BUILD_DIR")
    return (TOP / (given or "build-python")).resolve()


def _compile():
    """The folder with the built package."""
    build = _build_folder()
    is_new = not (build / "CMakeCache.txt").exists()
    options = [f"-DPython_EXECUTABLE={sys.executable}", "-DPTET_PYTHON=ON"]
    if is_new:
        options += ["-DCMAKE_BUILD_TYPE=Release", "-DPTET_BUILD_TOOLS=OFF", "-DPTET_BUILD_TESTS=OFF",
                    "-DPTET_BUILD_EXAMPLES=OFF"]
        if shutil.which("ninja") and "CMAKE_GENERATOR" not in os.environ:
            options += ["-G", "Ninja"]
        if shutil.which("ccache"):
            options += ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"]
    else:
        options = ["-DPTET_PYTHON=ON"]
    _run("cmake", "-S", TOP, "-B", build, *options)
    _run("cmake", "--build", build, "--target", "ptet_python_package", "--parallel", os.cpu_count() or 1)
    package = build / "python" / "ptet"
    module = package / ("_core" + sysconfig.get_config_var("EXT_SUFFIX"))
    if not module.exists():
        raise SystemExit(f"{build} is built for another Python than {sys.executable}: there is no {module.name}")
    return package


def _version():
    header = (TOP / "lib" / "include" / "ptet" / "version.hpp").read_text(encoding="utf-8")
    return re.search(r'kVersion = "([^"]+)"', header).group(1)


def _metadata(project):
    lines = ["Metadata-Version: 2.1", f"Name: {project['name']}", f"Version: {_version()}",
             f"Summary: {project['description']}", f"License: {project['license']['text']}",
             f"Requires-Python: {project['requires-python']}",
             *(f"Requires-Dist: {name}" for name in project["dependencies"]),
             "Description-Content-Type: text/markdown"]
    readme = (HERE / project["readme"]).read_text(encoding="utf-8")
    return "\n".join(lines) + "\n\n" + readme


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    project = tomllib.loads((HERE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    package = _compile()
    python = "cp" + sysconfig.get_config_var("py_version_nodot")
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    tag = f"{python}-{python}-{platform}"
    info = f"{project['name']}-{_version()}.dist-info"

    files = {f"ptet/{path.name}": path.read_bytes() for path in sorted(package.iterdir()) if path.is_file()}
    files[f"{info}/METADATA"] = _metadata(project).encode()
    files[f"{info}/WHEEL"] = (f"Wheel-Version: 1.0\nGenerator: ptet\nRoot-Is-Purelib: false\nTag: {tag}\n").encode()
    files[f"{info}/LICENSE"] = (TOP / "LICENSE").read_bytes()
    record = []
    for name, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        record.append(f"{name},sha256={digest},{len(content)}\n")
    record.append(f"{info}/RECORD,,\n")
    files[f"{info}/RECORD"] = "".join(record).encode()

    wheel = f"{project['name']}-{_version()}-{tag}.whl"
    with zipfile.ZipFile(pathlib.Path(wheel_directory) / wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), content, zipfile.ZIP_DEFLATED)
    return wheel
