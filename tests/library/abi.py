#!/usr/bin/env python3
"""Holds the C interface of libldp to its recorded form: types of functions, and every field's place in every struct.

  abi.py HEADER REFERENCE C_COMPILER          compares by abidiff; shows first that a planted change is told
  abi.py --record HEADER REFERENCE C_COMPILER writes the reference: with a release that adds something, or changes what
                                              no release had

What is compared is a library of empty functions made from ldp.h, which the real one is compiled against (symbols.sh tells
that it has them all). Skips (77) where abigail-tools is absent.
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

# Changes that readers built with an older header would not survive: (what is replaced, by what).
PLANTED = [("int32_t status;", "int64_t status;"), ("ldp_limits* limits,", "const char* limits,"),
           ("LDP_DAMAGED = 3", "LDP_DAMAGED = 9"), ("int layer,", "long layer,")]


def library_of(header, room, compiler):
    """The path of a library whose functions have the header's types, with debugging information."""
    plain = re.sub(r"/\*.*?\*/", "", header, flags=re.S)
    functions = re.findall(r"^((?:const )?\w+\**(?: |\*)\s*\**ldp_\w+\([^;{}]*?\));", plain, flags=re.S | re.M)
    (room / "ldp.h").write_text(header)
    (room / "ldp.c").write_text('#include "ldp.h"\n' + "".join(f"{one} {{ __builtin_trap(); }}\n" for one in functions))
    subprocess.run([compiler, "-std=c11", "-g", "-O0", "-shared", "-fPIC", "-Wno-unused-parameter", "-o", room / "libldp.so.0",
                    "-Wl,-soname,libldp.so.0", room / "ldp.c"], check=True)
    return len(functions), room / "libldp.so.0"


def main():
    words = [word for word in sys.argv[1:] if word != "--record"]
    header, reference, compiler = pathlib.Path(words[0]).read_text(), pathlib.Path(words[1]), words[2]
    if shutil.which("abidiff") is None:
        print("skipped: there is no abidiff: install abigail-tools")
        sys.exit(77)
    with tempfile.TemporaryDirectory() as folder:
        room = pathlib.Path(folder)
        count, library = library_of(header, room, compiler)
        if "--record" in sys.argv:
            subprocess.run(["abidw", "--no-corpus-path", "--no-show-locs", "--no-comp-dir-path", "--out-file", reference,
                            library], check=True)
            return
        listed = (reference.parent / "libldp0.symbols").read_text().count("\n ldp_")
        assert count == listed, f"{count} functions found in the header, {listed} in the list of symbols"
        for old, new in PLANTED:
            assert old in header, f"{old} is not in the header any more: plant another change"
            planted = library_of(header.replace(old, new, 1), room, compiler)[1]
            told = subprocess.run(["abidiff", reference, planted], capture_output=True, text=True)
            assert told.returncode & 4, f"{new} in place of {old} was not told"
        library = library_of(header, room, compiler)[1]
        told = subprocess.run(["abidiff", reference, library], capture_output=True, text=True)
        print(told.stdout, told.stderr)
        sys.exit(1 if told.returncode else 0)


if __name__ == "__main__":
    main()
