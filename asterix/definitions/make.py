#!/usr/bin/env python3
"""Makes the tables in this folder from the machine-readable definitions of the asterix-specs project
(https://github.com/zoranbosnjak/asterix-specs, BSD-3-Clause): one file per category, with all its editions.

    python3 asterix/definitions/make.py FOLDER            # writes catNNN.txt next to this script
    python3 asterix/definitions/make.py FOLDER --check    # writes nothing, exits with 1 if a file would change

FOLDER holds `catNNN-E.json.gz` (category, edition) and `catNNN-ref-E.json.gz` (its reserved expansion field), as published, with or
without gzip. Only facts are used: numbers and names of items, order, lengths, bits, LSBs, units, and dependences. Tables of codes and all
sentences are left out. The script fails on a definition with unknown content; whatever else it leaves out, `left()` reports on
standard output.

The form of a file, which `asterix/src/all/text.rs` reads:

    048 NAME                              category and its name in the newest edition
    editions 1.27 1.28 …                  the oldest first
    expansions 1.11 1.12 …                editions of the reserved expansion field, if it is defined
    uap 1.27-1.32 all 010 140 - …         editions, name of the profile, items by FRN; `-` is undefined, `RFS` random field sequencing
    select 1.2-1.4 020 TYP plot=0 …       item and field that select the profile of a record
    item 1.27-1.32 010 NAME               an item of these editions; the indented lines below are its layout
    re 1.11-1.13                          the reserved expansion field of these editions; the lines below are its subfields

Editions are `1.27`, a range `1.27-1.32` in the order of the list, or several of these separated by commas. A layout:

    FIELD FIELD …                         a fixed length
    ext FIELD … > FIELD …                 parts, each followed by FX; a part of whole octets is the last one and has no FX
    rep FIELD …                           an octet with a count, then this number of these fields
    repfx FIELD …                         these fields and FX, repeated while FX is set
    explicit                              an octet with the total length, then any octets
    expansion                             an octet with the total length, then the reserved expansion field
    comp                                  subfields, one line each with further indentation, `NAME LAYOUT`; `-` is an undefined one

A field is `NAME:BITS` and its kind. The name of a group precedes those of its fields, with a slash; the only value of an item has no
name. `_3` are three spare bits.

    NAME:4                                an integer, a code, or bits without further meaning
    NAME:24a  NAME:56x                    bits without further meaning: a 24-bit aircraft address, or more than 32 bits
    NAME:12o  NAME:48i  NAME:56t          octal digits; characters of 6 bits, of 8 bits
    NAME:64b                              a register of 56 bits, and its number of two times 4 bits
    NAME:16s1/2^8NM  NAME:16u1/4FL        a quantity, signed or unsigned, with LSB and unit; a signed integer has the LSB 1 and no unit
    NAME:15{IM 0=u1/2^14NM/s 1=…}         the kind depends on the preceding field IM
"""

import glob
import gzip
import json
import os
import re
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
HEADER = "# Made by make.py from the definitions of the asterix-specs project; see there for the form. Not to be edited.\n"


class Unknown(Exception):
    """A definition has content that our form cannot express."""


def must(condition, what):
    if not condition:
        raise Unknown(what)


def number(value):
    """A number in the form `1/2^8`."""
    contents = value["contents"]
    match value["tag"]:
        case "NumInt":
            return str(contents)
        case "NumDiv":
            return f"{number(contents['numerator'])}/{number(contents['denominator'])}"
        case "NumPow":
            return f"{contents['base']}^{contents['exponent']}"
    raise Unknown(value["tag"])


def sign(signedness):
    return {"Signed": "s", "Unsigned": "u"}[signedness["tag"]]


TEXTS = {"StringOctal": ("o", 3), "StringICAO": ("i", 6), "StringAscii": ("t", 8)}


def content(value, bits):
    """Kind of the bits of an element."""
    contents = value["contents"]
    match value["tag"]:
        case "ContentTable":
            return ""
        case "ContentRaw":
            return "a" if bits == 24 else "x" if bits > 32 else ""
        case "ContentInteger":
            return "s1" if sign(contents["signedness"]) == "s" else ""
        case "ContentQuantity":
            return f"{sign(contents['signedness'])}{number(contents['lsb'])}{contents['unit']}"
        case "ContentString":
            letter, each = TEXTS[contents["tag"]]
            must(bits % each == 0, f"{bits} bits of {contents['tag']}")
            return letter
        case "ContentBds":
            if contents["tag"] == "BdsWithAddress":
                must(bits == 64, "a register with its number of another length")
                return "b"
            return "x"
    raise Unknown(value["tag"])


def left(where, what):
    print(f"{where}: {what}")


def element(value, name, inside, where):
    bits, rule = value["bitSize"], value["rule"]
    if rule["tag"] == "ContextFree":
        return f"{name}:{bits}{content(rule['contents'], bits)}"
    must(rule["tag"] == "Dependent", rule["tag"])
    depends = rule["contents"]
    cases = [(key, content(case, bits)) for key, case in depends["cases"]]
    if {case for _, case in cases} == {""}:
        return f"{name}:{bits}"  # all of them are tables
    # The other field precedes this one in the same group.
    (path,), group = depends["path"], name.rpartition("/")[0]
    must(content(depends["default"], bits) == "", "a default that is no bare number")
    must(all(len(key) == 1 for key, _ in cases), "depends on several")
    other = "/".join(filter(None, [group, path[-1]]))
    must(any(field.startswith(f"{other}:") for field in inside), f"{other} is not before {name} in its item")
    return f"{name}:{bits}{{{other} {' '.join(f'{key[0]}={case}' for key, case in cases)}}}"


def size(variation):
    """Number of bits of an element or a group."""
    contents = variation["contents"]
    if variation["tag"] == "Element":
        return contents["bitSize"]
    must(variation["tag"] == "Group", variation["tag"])
    return sum(item["contents"] if item["tag"] == "Spare" else size(free(item["contents"], "")) for item in contents)


def free(item, where):
    """The structure of an item; if it depends on other items, its default."""
    rule = item["rule"]
    if rule["tag"] == "ContextFree":
        return rule["contents"]
    must(rule["tag"] == "Dependent", rule["tag"])
    default = rule["contents"]["default"]
    must(default["tag"] == "Element" and default["contents"]["rule"]["contents"]["tag"] == "ContentRaw", "a default with parts")
    must(all(size(case) == size(default) for _, case in rule["contents"]["cases"]), "cases of different lengths")
    if where:
        left(f"{where}/{item['name']}", f"{size(default)} bits whose parts depend on {rule['contents']['path']} stay one number")
    return default


def fields(variation, name, found, where):
    """Appends the fields of an element or a group."""
    if variation["tag"] == "Element":
        found.append(element(variation["contents"], name, found, where))
        return
    must(variation["tag"] == "Group", f"{variation['tag']} in fields")
    for item in variation["contents"]:
        member(item, name, found, where)


def member(item, name, found, where):
    if item["tag"] == "Spare":
        found.append(f"_{item['contents']}")
        return
    must(item["tag"] == "Item", item["tag"])
    inner = item["contents"]
    must(re.fullmatch("[A-Z0-9]+", inner["name"]), f"the name {inner['name']}")
    fields(free(inner, where), "/".join(filter(None, [name, inner["name"]])), found, where)


def whole(bits, where):
    must(bits % 8 == 0, f"{bits} bits are no whole octets")


def layout(variation, indent, where):
    """The lines of a layout; the first line follows a name."""
    contents = variation["contents"]
    match variation["tag"]:
        case "Element" | "Group":
            found = []
            fields(variation, "", found, where)
            whole(size(variation), where)
            return [" ".join(found)]
        case "Extended":
            parts, found = [], []
            for item in contents:
                if item is None:
                    parts.append((found, True))
                    found = []
                else:
                    member(item, "", found, where)
            if found:
                parts.append((found, False))
            for part, extends in parts:
                bits = sum(int(re.match(r"_(\d+)|.*?:(\d+)", field)[1] or re.match(r"_(\d+)|.*?:(\d+)", field)[2]) for field in part)
                whole(bits + extends, where)
            must(all(extends for _, extends in parts[:-1]), "a part without FX before the last")
            return ["ext " + " > ".join(" ".join(part) for part, _ in parts)]
        case "Repetitive":
            found, inner = [], contents["variation"]
            fields(inner, "", found, where)
            if contents["type"]["tag"] == "RepetitiveFx":
                whole(size(inner) + 1, where)
                return ["repfx " + " ".join(found)]
            must(contents["type"] == {"tag": "RepetitiveRegular", "contents": {"byteSize": 1}}, f"{contents['type']}")
            whole(size(inner), where)
            return ["rep " + " ".join(found)]
        case "Explicit":
            kind = contents["tag"] if contents else None
            must(kind in (None, "SpecialPurpose", "ReservedExpansion"), f"{kind}")
            return ["expansion" if kind == "ReservedExpansion" else "explicit"]
        case "Compound":
            return ["comp"] + subfields(contents, indent + 1, where)
    raise Unknown(variation["tag"])


def subfields(items, indent, where):
    lines = []
    for item in items:
        if item is None:
            lines.append(" " * indent + "-")
            continue
        must(re.fullmatch("[A-Z0-9]+", item["name"]), f"the name {item['name']}")
        first, *more = layout(free(item, where), indent, f"{where}/{item['name']}")
        lines += [" " * indent + f"{item['name']} {first}"] + more
    return lines


def items_of_uap(listed):
    names = {"UapItemSpare": "-", "UapItemRFS": "RFS"}
    return " ".join(item["contents"] if item["tag"] == "UapItem" else names[item["tag"]] for item in listed)


def blocks(definition, where):
    """(first line, lines below) of everything in an edition; `@` is a placeholder for the edition."""
    found, uap = [], definition["uap"]
    if uap["tag"] == "Uap":
        found.append((f"uap @ all {items_of_uap(uap['contents'])}", ()))
    else:
        must(uap["tag"] == "Uaps", uap["tag"])
        for name, listed in uap["contents"]["cases"]:
            found.append((f"uap @ {name} {items_of_uap(listed)}", ()))
        selector = uap["contents"]["selector"]
        item, *field = selector["item"]
        cases = " ".join(f"{name}={value}" for value, name in selector["cases"])
        found.append((f"select @ {item} {'/'.join(field) or '-'} {cases}", ()))
    named = {name for line, _ in found if line.startswith("uap") for name in line.split()[3:]}
    for item in definition["catalogue"]:
        # An item that is in no profile is never sent.
        if item["name"] in named:
            first, *more = layout(free(item, ""), 1, f"{where}/{item['name']}")
            found.append((f"item @ {item['name']} {item['title']}", (f" {first}", *more)))
    return found


def edition_of(definition):
    return f"{definition['edition']['major']}.{definition['edition']['minor']}"


def ranges(editions, every):
    """A list of editions in the form `1.27-1.29,1.31`."""
    places, runs = [every.index(edition) for edition in editions], []
    for place in places:
        if runs and runs[-1][1] == place - 1:
            runs[-1][1] = place
        else:
            runs.append([place, place])
    return ",".join(every[first] if first == last else f"{every[first]}-{every[last]}" for first, last in runs)


def gathered(by_edition, every):
    """The content of all editions without repetition, in the order of the newest edition that has it."""
    order, editions = [], {}
    for edition in reversed(every):
        for block in by_edition[edition]:
            if block not in editions:
                # An older form of an item follows the newer one.
                key = block[0].split()[:3] if block[0].startswith("item") else None
                alike = [place for place, other in enumerate(order) if key and other[0].split()[:3] == key]
                order.insert(alike[-1] + 1 if alike else len(order), block)
                editions[block] = []
            editions[block].insert(0, edition)
    return [(first.replace("@", ranges(editions[first, more], every), 1), more) for first, more in order]


def table(definitions, expansions):
    """The text of a category's file."""
    every = sorted(definitions, key=lambda edition: tuple(map(int, edition.split("."))))
    newest = definitions[every[-1]]
    lines = [f"{newest['category']:03} {newest['title']}", f"editions {' '.join(every)}"]
    extended = sorted(expansions, key=lambda edition: tuple(map(int, edition.split("."))))
    if extended:
        lines.append(f"expansions {' '.join(extended)}")
    said = {edition: blocks(definitions[edition], f"{newest['category']:03} {edition}") for edition in every}
    groups = [gathered(said, every)]
    if extended:
        fields_of = {}
        for edition in extended:
            must(expansions[edition]["fspecByteSize"] == 1, "more than one octet announces")
            where = f"{newest['category']:03} RE {edition}"
            fields_of[edition] = [("re @", tuple(subfields(expansions[edition]["items"], 1, where)))]
        groups.append(gathered(fields_of, extended))
    for group in groups:
        for first, more in group:
            lines += [first, *more]
    return HEADER + "\n".join(lines) + "\n"


def main():
    check = "--check" in sys.argv
    folders = [argument for argument in sys.argv[1:] if not argument.startswith("-")]
    if len(folders) != 1:
        sys.exit(__doc__)
    categories = {}
    for path in sorted(glob.glob(os.path.join(folders[0], "cat*.json*"))):
        with (gzip.open if path.endswith(".gz") else open)(path, "rt") as file:
            definition = json.load(file)
        contents = definition["contents"]
        of = categories.setdefault(contents["category"], ({}, {}))
        of[definition["tag"] == "AsterixExpansion"][edition_of(contents)] = contents
    if not categories:
        sys.exit(f"{folders[0]}: has no cat*.json or cat*.json.gz")
    differ = False
    for category, (definitions, expansions) in sorted(categories.items()):
        path = os.path.join(HERE, f"cat{category:03}.txt")
        try:
            text = table(definitions, expansions)
        except Unknown as what:
            sys.exit(f"category {category:03}: {what}")
        old = open(path).read() if os.path.exists(path) else None
        if old != text:
            differ = True
            if not check:
                with open(path, "w") as file:
                    file.write(text)
            print(f"{os.path.basename(path)}: {'differs' if check else 'written'}")
    sys.exit(check and differ)


if __name__ == "__main__":
    main()
