"""What type checkers are told against what is there; and that everything public says what it is."""
import ast
import dataclasses
import inspect
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import support  # noqa: F401  (leaves the source tree as it is)

import ptet
from ptet import _core

PACKAGE = pathlib.Path(ptet.__file__).parent


def stub_of_core():
    return ast.parse((PACKAGE / "_core.pyi").read_text(encoding="utf-8")).body


def arity(function):
    """How many arguments a function of the stub takes, and their names where they are not positional only."""
    arguments = function.args
    return (len(arguments.posonlyargs) + len(arguments.args), [argument.arg for argument in arguments.args])


def arity_in_core(function):
    """The same of a bound function, from the signature in its docstring."""
    text = function.__doc__.split("\n")[0]
    inner = text[text.index("(") + 1:text.rindex(") ->")]
    # Commas inside brackets part no arguments.
    depth, parts, part = 0, [], ""
    for letter in inner:
        depth += (letter in "[(") - (letter in "])")
        if letter == "," and depth == 0:
            parts.append(part)
            part = ""
        else:
            part += letter
    parts = [part.strip() for part in [*parts, part] if part.strip()]
    return len(parts), [part.split(":")[0] for part in parts if not re.match(r"arg\d+:", part)]


class Stubs(unittest.TestCase):
    def test_the_package_is_typed(self):
        self.assertTrue((PACKAGE / "py.typed").exists())

    def test_core_has_what_its_stub_has(self):
        told = {}
        for node in stub_of_core():
            if isinstance(node, ast.FunctionDef):
                told[node.name] = node
            elif isinstance(node, ast.ClassDef):
                told[node.name] = node
            elif isinstance(node, ast.AnnAssign):
                told[node.target.id] = node
        self.assertEqual(set(told), {name for name in vars(_core) if not name.startswith("_")})
        for name, node in told.items():
            there = getattr(_core, name)
            if isinstance(node, ast.FunctionDef):
                self.assertEqual(arity(node), arity_in_core(there), name)
            if not isinstance(node, ast.ClassDef):
                continue
            members = {}
            for member in node.body:
                members[member.name if isinstance(member, ast.FunctionDef) else member.target.id] = member
            # Without a constructor of its own it has that of every class.
            constructor = {"__init__"} if type(vars(there)["__init__"]).__name__ == "instancemethod" else set()
            ours = {key for key in vars(there) if not key.startswith("_")} | constructor
            if name == "Bytes":
                ours = {"__len__"}
            self.assertEqual(set(members), ours, name)
            for key, member in members.items():
                bound = vars(there)[key]
                if isinstance(bound, property):
                    is_property = isinstance(member, ast.AnnAssign) or any(
                        decorator.id == "property" for decorator in member.decorator_list)
                    self.assertTrue(is_property, f"{name}.{key}")
                    self.assertEqual(isinstance(member, ast.AnnAssign), bound.fset is not None, f"{name}.{key}")
                else:
                    count, names = arity(member)
                    names = [argument for argument in names if argument != "self"]
                    bound_count, bound_names = arity_in_core(bound)
                    bound_names = [argument for argument in bound_names if argument != "self"]
                    self.assertEqual((count, names), (bound_count, bound_names), f"{name}.{key}")

    def test_everything_public_is_annotated_and_described(self):
        for name in ptet.__all__:
            thing = getattr(ptet, name)
            if inspect.isfunction(thing) or inspect.isclass(thing):
                self.assertTrue(inspect.getdoc(thing), name)
            functions = [thing] if inspect.isfunction(thing) else []
            if inspect.isclass(thing):
                for key, member in vars(thing).items():
                    member = member.fget if isinstance(member, property) else member
                    if inspect.isfunction(member) and not key.startswith("_"):
                        self.assertTrue(inspect.getdoc(member), f"{name}.{key}")
                        functions.append(member)
            for function in functions:
                signature = inspect.signature(function)
                self.assertIsNot(signature.return_annotation, inspect.Signature.empty, function.__qualname__)
                for parameter in list(signature.parameters.values()):
                    if parameter.name != "self":
                        self.assertIsNot(parameter.annotation, parameter.empty, function.__qualname__)

    def test_docstrings_name_every_argument(self):
        for function in (ptet.build, ptet.open, ptet.Dataset.extract):
            text = inspect.getdoc(function)
            told = text[text.index("Args:"):text.index("Raises:")]
            for name in inspect.signature(function).parameters:
                if name != "self":
                    self.assertRegex(told, rf"\b{name}\b[^\n]*:", function.__qualname__)
        for described in (ptet.Extraction, ptet.DatasetInfo, ptet.BuildReport, ptet.SessionUpdate, ptet.MeshReport):
            names = ([field.name for field in dataclasses.fields(described)] if dataclasses.is_dataclass(described)
                     else described.__annotations__)
            for name in names:
                self.assertRegex(described.__doc__, rf"\b{name}\b[^\n]*:", described.__name__)

    def test_sessions_and_extractions_ask_alike(self):
        extract = inspect.signature(ptet.Dataset.extract).parameters
        update = inspect.signature(ptet.Session.update).parameters
        self.assertEqual({name: extract[name] for name in update}, dict(update))
        self.assertEqual(set(extract) - set(update), {"input_order"})

    def test_type_checker(self):
        """The package by itself, and a user's file with what must be refused."""
        try:
            import mypy  # noqa: F401
        except ImportError:
            self.skipTest("mypy is not here")
        user = ("import numpy as np\nimport ptet\n"
                "data = ptet.open('x')\n"
                "cut = data.extract(error='2%', focus=[ptet.Box((0, 0, 0), (1, 1, 1), falloff='1%')], budget=3)\n"
                "total: int = len(cut.tets) + cut.failures[0].block\n"
                "error: float = cut.field_error['t'] + data.session().update(error={'t': 2}).domain_error\n"
                "data.extract(errors=3)  # call-arg\n"
                "data.extract(focus=(0, 0, 0))  # arg-type\n"
                "ptet.build(np.zeros((4, 3)), [[0, 1, 2, 3]], {'t': [1.0]}, method=3)  # arg-type\n"
                "cut.nothing  # attr-defined\n")
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "user.py"
            path.write_text(user, encoding="utf-8")
            done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports",
                                   "--cache-dir", folder + "/cache", path, *sorted(PACKAGE.glob("*.py"))],
                                  cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8",
                                  check=False)
        lines = enumerate(user.splitlines(), 1)
        wanted = [(str(number), line.split("# ")[1]) for number, line in lines if "# " in line]
        found = re.findall(r"^(\S+?):(\d+): error: .*\[([\w-]+)\]$", done.stdout, re.M)
        self.assertEqual([(number, code) for _, number, code in found], wanted, done.stdout)
        self.assertEqual({pathlib.Path(file).name for file, _, _ in found}, {"user.py"}, done.stdout)


if __name__ == "__main__":
    unittest.main()
