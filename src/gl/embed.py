# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT

"""embed.py OUT.c FILE.glsl...: the shaders as C strings, found by folder and name ("gl/reduce.glsl"). Comments and empty lines
stay out of them; the files are ASCII."""
import os
import sys


def lines(path):
    with open(path, encoding="ascii") as f:
        for number, line in enumerate(f, 1):
            code = line.split("//")[0].rstrip()
            if code:
                yield number, code


out = [
    "/* Made by src/gl/embed.py from shaders/. */",
    '#include "gl/shaders.h"',
    "",
    "#include <string.h>",
    "",
]
names = []
for index, path in enumerate(sys.argv[2:]):
    name = "/".join(path.replace(os.sep, "/").split("/")[-2:])
    names.append(name)
    text, last = "", 0
    for number, code in lines(path):
        if number != last + 1:
            text += "#line %d\n" % number  # so that a driver's message names the line of the file
        last = number
        text += code + "\n"
    # Bytes, not a literal: C promises no literals of more than 4095 characters.
    out.append("static const char text_%d[] = {" % index)
    data = text.encode() + b"\0"
    for at in range(0, len(data), 24):
        out.append("    " + ", ".join(map(str, data[at : at + 24])) + ",")
    out.append("};")
out.append("static const struct {")
out.append("    const char *name, *text;")
out.append("} shaders[] = {")
out += ['    {"%s", text_%d},' % (name, index) for index, name in enumerate(names)]
out += [
    "};",
    "",
    "const char *shader_text(const char *name) {",
    "    for (size_t i = 0; i < sizeof shaders / sizeof *shaders; i++)",
    "        if (!strcmp(shaders[i].name, name)) return shaders[i].text;",
    '    return "";',
    "}",
]
with open(sys.argv[1], "w", encoding="ascii") as f:
    f.write("\n".join(out) + "\n")
