#!/usr/bin/env python3
"""Write the twin of a source file that is compiled for wide registers: vi_lane*, vi_march become vi_..._wide."""

import re
import sys
from pathlib import Path

source, target = map(Path, sys.argv[1:])
text = source.read_text(encoding="utf-8")
target.write_text(re.sub(r"\b(vi_lane[a-z_]*|vi_march)\b", r"\1_wide", text), encoding="utf-8")
