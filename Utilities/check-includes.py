#!/usr/bin/env python3
"""Checks the direction of includes between the layers and between the folders of Logic/Core, and which layers use which other
libraries. Prints every violation, and exits with 1 if there is one."""
import pathlib
import re
import sys

# A layer may include itself and the layers listed here. A set names the only headers of a layer that it may include.
N4 = {"IO/N4Correction.h"}
LAYERS = {
    "Logic/Core": {},
    "Logic/Cuda": {"Logic/Core": None},
    "Logic/Onnx": {"Logic/Core": None},
    "Logic/Text": {"Logic/Core": None, "Logic/Onnx": None},
    "Logic/IO": {"Logic/Core": None},
    "Logic/Evaluation": {"Logic/Core": None, "Logic/IO": N4},
    "Logic/VTK": {"Logic/Core": None, "Logic/Onnx": None, "Logic/Text": None, "Logic/IO": N4},
    "Logic/MRML": {"Logic/Core": None, "Logic/Onnx": None, "Logic/Text": None, "Logic/IO": None, "Logic/Evaluation": None,
                   "Logic/VTK": None},
    "Logic/CLI": {"Logic/Core": None, "Logic/Onnx": None, "Logic/Text": None, "Logic/IO": None, "Logic/Evaluation": None},
    "Widgets": {"Logic/Core": None, "Logic/Text": None, "Logic/VTK": None,
                "Logic/IO": {"IO/FilePath.h", "IO/Ply.h", "IO/RecoveredFit.h"}},
    "Widgets/App": {"Logic/Core": None, "Logic/Text": None, "Logic/IO": None, "Logic/Evaluation": None, "Logic/VTK": None,
                    "Widgets": None},
    "InnerGSModule": {"Logic/Core": None, "Logic/Text": None, "Logic/VTK": None, "Logic/MRML": None, "Widgets": None},
}
# Headers of other libraries, and the layers that may include them.
LIBRARIES = {
    "ITK": (r"itk", ["Logic/IO", "Logic/Evaluation", "Logic/CLI"]),
    "VTK": (r"vtk", ["Logic/VTK", "Logic/MRML", "Widgets", "Widgets/App", "InnerGSModule"]),
    "Qt": (r"Q[A-Z]|Qt", ["Widgets", "Widgets/App", "InnerGSModule"]),
    "nlohmann-json": (r"nlohmann/", ["Logic/Text", "Logic/IO", "Logic/Evaluation", "Logic/CLI"]),
    "CLI11": (r"CLI/", ["Logic/CLI", "Widgets/App"]),
    "spdlog": (r"spdlog/", ["Logic/CLI"]),
    "Highway": (r"hwy/", ["Logic/Core"]),
}
ROOTS = ["Logic", "Logic/VTK", "Logic/MRML", "Widgets", "Widgets/App", "InnerGSModule", "."]
SUFFIXES = {".h", ".cxx", ".cu", ".cuh"}
SOURCE = pathlib.Path(__file__).resolve().parent.parent
INCLUDE = re.compile(r'^\s*#\s*include\s+(?:"([^"]+)"|<([^>]+)>)', re.MULTILINE)


def table_after(text, sentence):
    """The first column of CONTRIBUTING.md's table after a sentence."""
    rows = text[text.index(sentence):].split("|---|", 1)[1].split("\n\n", 1)[0]
    return re.findall(r"^\| `([^`]+)` \|", rows, re.MULTILINE)


def layer_of(path):
    return max((layer for layer in LAYERS if path.is_relative_to(layer)), key=len, default=None)


def core_folder_of(path):
    return path.parts[2] if path.is_relative_to("Logic/Core") and len(path.parts) > 3 else None


def violations(file, core):
    layer = layer_of(file)
    if layer == "Logic/Core" and core_folder_of(file) not in core:
        yield f"{file}: belongs into one of the folders {', '.join(core)}"
        return
    for quoted, angled in INCLUDE.findall((SOURCE / file).read_text(encoding="utf-8")):
        name = quoted or angled
        candidates = [file.parent / name] + [pathlib.Path(root) / name for root in ROOTS]
        target = next((c for c in candidates if (SOURCE / c).is_file()), None)
        if target is None:  # generated, or from another library
            for library, (pattern, users) in LIBRARIES.items():
                if re.match(pattern, name) and layer not in users:
                    yield f"{file}: {layer} may not use {library} ({name})"
            continue
        to = layer_of(target)
        if to and to != layer:
            headers = LAYERS[layer].get(to, set())
            if headers is not None and target.as_posix().removeprefix("Logic/") not in headers:
                yield f"{file}: {layer} may not include {target}"
        if layer == to == "Logic/Core" and core.index(core_folder_of(target)) > core.index(core_folder_of(file)):
            yield f"{file}: {core_folder_of(file)} lies below {target}"


def main():
    contributing = (SOURCE / "CONTRIBUTING.md").read_text(encoding="utf-8")
    # A folder of Logic/Core may include itself and those before it.
    core = table_after(contributing, "`Logic/Core` has a folder per concept")
    wrong = []
    if sorted(table_after(contributing, "## Layers")) != sorted(LAYERS):
        wrong.append("CONTRIBUTING.md's table of layers names others than this check.")
    if sorted(core) != sorted(p.name for p in (SOURCE / "Logic/Core").iterdir() if p.is_dir()):
        wrong.append("CONTRIBUTING.md's table of Logic/Core names other folders than there are.")
    files = {p.relative_to(SOURCE) for layer in LAYERS for p in (SOURCE / layer).rglob("*") if p.suffix in SUFFIXES}
    for file in sorted(files):
        wrong += violations(file, core)
    if len(files) < 100:
        wrong.append(f"Only {len(files)} files were found: the check looks in the wrong place.")
    print("\n".join(wrong) if wrong else f"{len(files)} files include one way.")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
