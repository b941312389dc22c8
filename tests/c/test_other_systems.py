"""Check the syntax and types of code for other systems, with declarations of those systems."""

import shutil
import subprocess

import pytest
from installed_library import ROOT

SOURCES = [
    ROOT / "src/numerics/process.c",
    ROOT / "src/cli/last_error.c",
    ROOT / "src/cli/file_size.c",
]
STANDARD = {
    "stdint.h": "typedef unsigned long size_t;\n#define SIZE_MAX 0xffffffffffffffffUL\n",
    "stdlib.h": "typedef unsigned long size_t;\nvoid *malloc(size_t);\nvoid free(void *);\n"
    "char *getenv(const char *);\nunsigned long long strtoull(const char *, char **, int);\n"
    "#define NULL ((void *)0)\n",
    "ctype.h": "int isspace(int);\nint toupper(int);\n",
    "limits.h": "#define INT_MAX 0x7fffffff\n",
    "errno.h": "int *error_number(void);\n#define errno (*error_number())\n",
    "string.h": "typedef unsigned long size_t;\nint strerror_r(int, char *, size_t);\n"
    "char *strncpy(char *, const char *, size_t);\n",
    "signal.h": "void (*signal(int, void (*)(int)))(int);\n#define SIG_IGN ((void (*)(int))1)\n"
    "#define SIGXFSZ 25\n",
    "pthread.h": "typedef unsigned long size_t;\ntypedef struct opaque *pthread_t;\n"
    "typedef struct { long state; } pthread_attr_t;\npthread_t pthread_self(void);\n"
    "int pthread_atfork(void (*)(void), void (*)(void), void (*)(void));\n"
    "int pthread_attr_init(pthread_attr_t *);\nint pthread_attr_destroy(pthread_attr_t *);\n"
    "int pthread_attr_getstacksize(const pthread_attr_t *, size_t *);\n"
    "void *pthread_get_stackaddr_np(pthread_t);\nsize_t pthread_get_stacksize_np(pthread_t);\n",
}
#: Macro defined by a system's compiler, and headers that it lacks.
SYSTEMS = {"macOS": ("__APPLE__", ()), "Windows": ("_WIN32", ("pthread.h",))}


@pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no gcc")
@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("source", SOURCES, ids=lambda path: path.name)
def test_syntax(source, system, tmp_path):
    """The code for a system compiles with its declarations; it is not run (see docs/limits.md)."""
    macro, lacking = SYSTEMS[system]
    for name, text in STANDARD.items():
        if name not in lacking:
            (tmp_path / name).write_text(f"#pragma once\n{text}")
    done = subprocess.run(
        ["gcc", "-fsyntax-only", "-std=c11", "-Wall", "-Wextra", "-Werror", "-nostdinc", "-U__linux__",
         "-isystem", tmp_path, f"-D{macro}=1", source],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
