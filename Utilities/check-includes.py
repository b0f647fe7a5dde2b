#!/usr/bin/env python3
"""Checks the direction of includes between the layers and between the folders of Logic/Core. Prints every violation, and
exits with 1 if there is one."""
import pathlib
import re
import sys

# A layer may include itself and the layers listed here.
LAYERS = {
    "Logic/Core": [],
    "Logic/Cuda": ["Logic/Core"],
    "Logic/Onnx": ["Logic/Core"],
    "Logic/Text": ["Logic/Core", "Logic/Onnx"],
    "Logic/IO": ["Logic/Core"],
    "Logic/Evaluation": ["Logic/Core", "Logic/IO"],
    "Logic/VTK": ["Logic/Core", "Logic/Onnx", "Logic/Text", "Logic/IO"],
    "Logic/MRML": ["Logic/Core", "Logic/Onnx", "Logic/Text", "Logic/IO", "Logic/Evaluation", "Logic/VTK"],
    "Logic/CLI": ["Logic/Core", "Logic/Onnx", "Logic/Text", "Logic/IO", "Logic/Evaluation"],
    "Widgets": ["Logic/Core", "Logic/Text", "Logic/IO", "Logic/VTK"],
    "Widgets/App": ["Logic/Core", "Logic/Text", "Logic/IO", "Logic/Evaluation", "Logic/VTK", "Widgets"],
    "InnerGSModule": ["Logic/Core", "Logic/Text", "Logic/IO", "Logic/Evaluation", "Logic/VTK", "Logic/MRML",
                      "Widgets"],
}
# A folder of Logic/Core may include itself and those before it.
CORE = ["Base", "Image", "Model", "Settings", "Acquisition", "Alignment", "Prediction", "Uncertainty", "Render", "Features",
        "Fit", "Device", "Job", "Motion"]
ROOTS = ["Logic", "Logic/VTK", "Logic/MRML", "Widgets", "Widgets/App", "InnerGSModule", "."]
SUFFIXES = {".h", ".cxx", ".cu", ".cuh"}


def layer_of(path):
    return max((layer for layer in LAYERS if path.is_relative_to(layer)), key=len, default=None)


def core_folder_of(path):
    return path.parts[2] if path.is_relative_to("Logic/Core") and len(path.parts) > 3 else None


def main():
    source = pathlib.Path(__file__).resolve().parent.parent
    wrong = []
    files = [p.relative_to(source) for layer in LAYERS for p in (source / layer).rglob("*") if p.suffix in SUFFIXES]
    for file in sorted(set(files)):
        layer = layer_of(file)
        if layer == "Logic/Core" and core_folder_of(file) not in CORE:
            wrong.append(f"{file}: belongs into one of the folders {', '.join(CORE)}")
            continue
        for name in re.findall(r'^\s*#\s*include\s+"([^"]+)"', (source / file).read_text(encoding="utf-8"), re.MULTILINE):
            candidates = [file.parent / name] + [pathlib.Path(root) / name for root in ROOTS]
            target = next((c for c in candidates if (source / c).is_file()), None)
            if target is None:
                continue  # generated, or from another library
            to = layer_of(target)
            if to and to != layer and to not in LAYERS[layer]:
                wrong.append(f"{file}: {layer} may not include {target}")
            if layer == to == "Logic/Core" and CORE.index(core_folder_of(target)) > CORE.index(core_folder_of(file)):
                wrong.append(f"{file}: {core_folder_of(file)} lies below {target}")
    if len(files) < 100:
        wrong.append(f"Only {len(files)} files were found: the check looks in the wrong place.")
    print("\n".join(wrong) if wrong else f"{len(files)} files include one way.")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
