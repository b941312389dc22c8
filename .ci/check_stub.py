"""Compare _core.pyi with what f2py says of each procedure: stubtest cannot see f2py's arguments."""

import ast
import sys
from pathlib import Path

from vibroimpact import _core

stub = Path(__file__).parents[1] / "python" / "vibroimpact" / "_core.pyi"
tree = ast.parse(stub.read_text(encoding="utf-8"))
calls = {item.name: item.body[0].args for item in tree.body if isinstance(item, ast.ClassDef)}
faults = 0
for item in tree.body:
    if isinstance(item, ast.AnnAssign) and item.annotation.id in calls:
        name = item.target.id
        written = [argument.arg for argument in calls[item.annotation.id].args[1:]]
        # the first line is: result,result = name(argument,argument,[optional])
        first_line = getattr(_core, name).__doc__.splitlines()[0]
        arguments = first_line.partition("(")[2].rstrip(")").translate(str.maketrans("", "", "[]"))
        if written != arguments.split(","):
            faults += 1
            print(f"{name}: _core.pyi has {','.join(written)}, f2py has {arguments}")
sys.exit(faults > 0)
