#!/usr/bin/env python3
"""Write the single-precision twin of one core source file: every module vi_* becomes vi_*_single.

The kind itself is not touched: the twin uses vi_kinds_single in place of vi_kinds.
"""

import re
import sys
from pathlib import Path

source, target = map(Path, sys.argv[1:])
text = source.read_text(encoding="utf-8")
target.write_text(re.sub(r"\bvi_([a-z_]+)\b", r"vi_\1_single", text), encoding="utf-8")
