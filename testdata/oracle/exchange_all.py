#!/usr/bin/env python3
"""Exchanges random records of every category and edition with libasterix, a codec made by others from the same specifications.

    pip install libasterix==0.36.3
    python3 exchange_all.py [--binary PROGRAM] [--seed N] [--count N] [--jobs N] [--only 48 | 48:1.31] …

PROGRAM is a built `utm-fusion`, by default the release build. `exchange.py` does the same for the typed records; here all editions go by
their definitions (`decode --untyped`), those with typed records too, and each reserved expansion field with the newest of its category:

* read: libasterix makes blocks of random records, `decode` reads them. Every item, every field and every bit must be there, under the key
  that the rules of `asterix::all` give it, within 0.45 LSB of the count, and nothing else; `encode` must give back the octets.
* write: this script makes lines of random records of libasterix, each physical value up to 0.45 LSB beside its count and the members in any
  order, and `encode` must make the same octets as libasterix.

What is said here of keys and units is written down a second time, on purpose. Ends with 1 where anything differs.
"""

import argparse
import json
import multiprocessing
import os
import random
import subprocess
import sys
import tempfile
import time

import asterix.generated as generated
from asterix import base

from exchange import FIRST, any_argument, any_octets, keeping, run, split

RELEASE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../target/release/utm-fusion")
STRICT = base.ParsingMode.StrictParsing

# A unit of the specification: how keys end, and how many of ours it is.
UNITS = {
    "": ("", 1), "%": ("percent", 1), "ALTFL": ("flight_level", 1), "FL": ("flight_level", 1), "MHz": ("mhz", 1), "Mach": ("mach", 1),
    "NM": ("m", 1852), "NM/s": ("m_s", 1852), "dB": ("db", 1), "dBm": ("dbm", 1), "dBm²": ("dbm2", 1), "dBµV": ("dbuv", 1), "fs": ("fs", 1),
    "ft": ("m", 0.3048), "ft/min": ("m_s", 0.3048 / 60), "hPa": ("hpa", 1), "mb": ("hpa", 1), "kt": ("m_s", 1852 / 3600), "m": ("m", 1),
    "m/s": ("m_s", 1), "m/s²": ("m_s2", 1), "m²": ("m2", 1), "ms": ("ms", 1), "ns": ("ns", 1), "s": ("s", 1), "°": ("deg", 1),
    "°/s": ("deg_s", 1), "°C": ("c", 1),
}


# --- Records of libasterix in the form of our lines ---------------------------------------------------------------------------------------

class Number:
    """A count, or a quantity of so many LSBs."""

    def __init__(self, count, lsb=None):
        self.count, self.lsb = count, lsb

    def make(self, rng):
        if self.lsb is None:
            return self.count
        return (self.count + rng.choice([0, rng.uniform(-0.45, 0.45)])) * self.lsb

    def is_said_by(self, value):
        if type(value) not in (int, float):
            return False
        return value == self.count if self.lsb is None else abs(value / self.lsb - self.count) <= 0.45


class Text:
    """Digits or characters."""

    def __init__(self, text):
        self.text = text

    def make(self, rng):
        return self.text

    def is_said_by(self, value):
        return value == self.text


def characters(octets, codes, is_known):
    """A text, or its octets where a code stands for no character."""
    return Text("".join(map(chr, codes)) if all(map(is_known, codes)) else {"hex": octets.hex()})


def leaf(content, bits, count):
    """(end of the key, what it says)."""
    if issubclass(content, base.ContentQuantity):
        ending, factor = UNITS[content.cv_unit]
        signed = content.cv_signedness is base.Signed
        if not signed and not ending and content.cv_lsb == 1:
            return "", Number(count)
        return ending, Number(count - (count >> (bits - 1) << bits if signed else 0), content.cv_lsb * factor)
    if issubclass(content, base.ContentInteger) and content.cv_signedness is base.Signed:
        return "", Number(count - (count >> (bits - 1) << bits), 1)
    if issubclass(content, base.ContentString):
        octets = count.to_bytes((bits + 7) // 8, "big")
        if content.cv_string_type is base.StringOctal:
            return "", Text(f"{count:0{bits // 3}o}")
        if content.cv_string_type is base.StringICAO:
            codes = [count >> at & 63 for at in range(bits - 6, -1, -6)]
            codes = [code + 64 if 1 <= code <= 26 else code if code == 32 or 48 <= code <= 57 else 0 for code in codes]
            return "", characters(octets, codes, bool)
        return "", characters(octets, octets, lambda octet: 32 <= octet <= 126)
    if issubclass(content, base.ContentRaw) and bits == 24:
        return "", Text(f"{count:06X}")
    if issubclass(content, base.ContentBds) or issubclass(content, base.ContentRaw) and bits > 32:
        return "", Text(f"{count:0{bits // 4}x}")
    return "", Number(count)


def key(name, ending):
    name = name.removesuffix("/VAL").replace("/", "_").lower()
    if not ending or (name, ending) == ("fl", "flight_level"):
        return ending or name
    return f"{name or 'value'}_{ending}"


def add_element(found, name, fields, counts):
    """Adds the members that a value is."""
    rule, bits, count = found.cv_rule, found.cv_bit_size, found.as_uint()
    if issubclass(rule, base.RuleContentDependent):
        content = rule.cv_default_content
        if rule.cv_depends_on[0][-1] in counts:
            content = dict((value[0], case) for value, case in rule.cv_cases).get(counts[rule.cv_depends_on[0][-1]], content)
    else:
        content = rule.cv_content
    counts[name.rpartition("/")[2]] = count
    if issubclass(content, base.ContentBds) and bits == 64:
        fields.update({"data": Text(f"{count >> 8:014x}"), "bds1": Number(count >> 4 & 15), "bds2": Number(count & 15)})
        return
    ending, value = leaf(content, bits, count)
    # A time of day is a number alone.
    is_time = not name and (bits, ending) == (24, "s") and content.cv_lsb == 1 / 128 and content.cv_signedness is base.Unsigned
    name = "" if is_time else key(name, ending)
    assert name not in fields
    fields[name] = value


def inside(rule):
    """The structure in an item; where it depends on others, its bits."""
    return rule.arg if isinstance(rule, base.RuleVariationContextFree) else rule


def add_items(items, name, fields, counts):
    for item in items:
        if isinstance(item, base.Spare):
            if item.as_uint():
                spares = counts["spare"] + 1
                fields["spare" if spares == 1 else f"spare_{spares}"] = Number(item.as_uint())
            counts["spare"] += 1
            continue
        inner = inside(item.arg.arg)
        path = "/".join(filter(None, [name, item.cv_non_spare.cv_name]))
        if isinstance(inner, base.RuleVariationDependent):
            fields[key(path, "")] = Number(inner.unparse().to_uinteger())
        elif isinstance(inner, base.Element):
            add_element(inner, path, fields, counts)
        else:
            add_items(inner.arg, path, fields, counts)


def value_of(fields, subfield):
    """Fields, or the only one without a name; a subfield's says the unit of that: (end of its key, what it says)."""
    if set(fields) == {""}:
        return "", fields[""]
    if subfield and len(fields) == 1 and next(iter(fields)).startswith("value_"):
        (name, value), = fields.items()
        return name.removeprefix("value_"), value
    return "", fields


def structure(found, subfield=False):
    """(end of the key, what stands there)."""
    if isinstance(found, base.Element):
        fields = {}
        add_element(found, "", fields, {"spare": 0})
        if subfield and set(fields) == {""} and fields[""].__class__ is Number and is_seconds(found):
            return "s", fields[""]
        return value_of(fields, subfield)
    if isinstance(found, base.Group):
        fields = {}
        add_items(found.arg, "", fields, {"spare": 0})
        return "", fields
    if isinstance(found, base.Extended):
        fields = {}
        add_items([item for part in found.arg for item in part if item is not None], "", fields, {"spare": 0})
        if hasattr(found, "more"):
            fields["more"] = Text(found.more.hex())
        return "", fields
    if isinstance(found, base.Repetitive):
        each = [structure(part, subfield) for part in found.arg]
        return repeated_ending(found.cv_variation) if subfield else "", [value for _, value in each]
    if isinstance(found, base.Compound):
        return "", subfields(found)
    octets = found.get_bytes()
    return "", Text(bytes([len(octets) + 1]).hex() + octets.hex())


def is_seconds(found):
    return issubclass(found.cv_rule.cv_content, base.ContentQuantity) and found.cv_rule.cv_content.cv_unit == "s"


def repeated_ending(spec):
    """The unit of what is repeated, also where there is none of it."""
    if not issubclass(spec, base.Element):
        return ""
    return leaf(spec.cv_rule.cv_content, spec.cv_bit_size, 0)[0]


def subfields(found):
    made = {}
    for name, subfield in found.arg.items():
        ending, value = structure(inside(subfield.arg), True)
        made[key(name, ending)] = value
    return made


def record_of(record, expansion):
    """The items of a record of libasterix."""
    items, sequences = {}, [rfs for rfs in record.items_rfs if rfs is not None]
    for spec in record.cv_items_list:
        if issubclass(spec, base.UapItem) and spec.cv_non_spare.cv_name in record.items_regular:
            name = spec.cv_non_spare.cv_name
            items[name] = item_of(name, record.items_regular[name], expansion)
        elif issubclass(spec, base.UapItemRFS) and sequences:
            items["RFS"] = [{name: item_of(name, item, expansion)} for name, item in sequences.pop()]
    return items


def item_of(name, item, expansion):
    inner = inside(item.arg)
    if name == "RE" and expansion:
        octets = inner.get_bytes()
        # Extended items may be longer than their edition describes, here as everywhere.
        with keeping("extension"):
            result = expansion._parse(base.Bits.from_bytes(octets))
        if not isinstance(result, ValueError) and not len(result[1]):
            return subfields(result[0])
    return structure(inner)[1]


# --- Comparison and lines --------------------------------------------------------------------------------------------------------------

def differences(wanted, value, path):
    if isinstance(wanted, dict):
        if not isinstance(value, dict):
            yield f"{path} is no object, but {value!r}"
        elif list(wanted) != list(value):
            yield f"{path} has {list(value)} instead of {list(wanted)}"
        else:
            for name in wanted:
                yield from differences(wanted[name], value[name], f"{path}/{name}")
    elif isinstance(wanted, list):
        if not isinstance(value, list) or len(value) != len(wanted):
            yield f"{path} is no array of {len(wanted)}"
        else:
            for index, (one, other) in enumerate(zip(wanted, value)):
                yield from differences(one, other, f"{path}[{index}]")
    elif not wanted.is_said_by(value):
        yield f"{path} is {value!r}, but should be {vars(wanted)}"


def line_of(wanted, rng):
    if isinstance(wanted, dict):
        return {name: line_of(wanted[name], rng) for name in rng.sample(list(wanted), len(wanted))}
    if isinstance(wanted, list):
        return [line_of(part, rng) for part in wanted]
    return wanted.make(rng)


def leaves(wanted):
    if isinstance(wanted, (dict, list)):
        return sum(map(leaves, wanted.values() if isinstance(wanted, dict) else wanted))
    return 1


# --- Random records --------------------------------------------------------------------------------------------------------------------

class Edition:
    """A category, an edition of it, and one of its reserved expansion field."""

    def __init__(self, category, spec, expansion):
        self.category, self.spec, self.expansion = category, spec, expansion and expansion.cv_expansion
        self.name = "{}.{}".format(*spec.cv_edition)
        self.chosen = self.name + ("/{}.{}".format(*expansion.cv_edition) if expansion else "")
        self.uaps = {None: spec.cv_uap.cv_record} if issubclass(spec.cv_uap, base.UapSingle) else spec.cv_uap.cv_uaps
        self.selector = getattr(spec.cv_uap, "cv_selector", None)

    def record(self, rng):
        """A random record, which says its profile where there are several."""
        uap = rng.choice(list(self.uaps))
        spec, items, sequences = self.uaps[uap], {}, []
        share = rng.choice([0.1, 0.4, 0.4, 0.4, 1.0])
        regular = {item.cv_non_spare.cv_name: item.cv_non_spare for item in spec.cv_items_list if issubclass(item, base.UapItem)}
        for name, item in regular.items():
            if rng.random() < share or uap and name == self.selector[0][0]:
                items[name] = self.item(rng, name, item)
        if uap:
            (item, *_), cases = self.selector
            value = rng.choice([value for value, name in cases.items() if name == uap])
            given = items[item]
            items[item] = value if isinstance(given, int) else [(value, *given[0][1:]), *given[1:]]
        if any(issubclass(item, base.UapItemRFS) for item in spec.cv_items_list) and rng.random() < share:
            names = rng.choices(list(regular), k=rng.randint(1, 3))
            sequences.append([(name, self.item(rng, name, regular[name])) for name in names])
        return spec.create(items, *sequences)

    def item(self, rng, name, spec):
        if name == "RE" and self.expansion:
            while rng.random() < 0.8:
                share = rng.choice([0.1, 0.4, 0.4, 1.0])
                listed = [item for item in self.expansion.cv_items_list if item is not None and rng.random() < share]
                made = self.expansion.create({item.cv_name: argument(rng, item) for item in listed}).unparse().to_bytes()
                if len(made) <= 254:
                    return made
            return any_octets(rng)
        return argument(rng, spec)

    def block(self, rng, most):
        records = [self.record(rng) for _ in range(rng.randint(1, most))]
        return records, self.spec.create(records).unparse().to_bytes()


# Where the structure of an item depends on others, `exchange` makes it of the bits alone.
for rule in vars(generated).values():
    if isinstance(rule, type) and issubclass(rule, base.RuleVariationDependent) and hasattr(rule, "cv_default_variation"):
        rule.cv_variation = rule.cv_default_variation


def argument(rng, spec):
    """What libasterix makes a random item from."""
    return any_argument(rng, spec.cv_rule.cv_variation)


def every_edition():
    for category, specs in generated.manifest["CATS"].items():
        expansions = generated.manifest["REFS"].get(category, [])
        for spec in specs:
            yield Edition(category, spec, expansions[-1] if expansions else None)
        for expansion in expansions[:-1]:
            yield Edition(category, specs[-1], expansion)


# --- Both ways -------------------------------------------------------------------------------------------------------------------------

class Tally:
    def __init__(self):
        self.records = self.values = 0
        self.differences = []


def read(edition, binary, seed, count, tally):
    """libasterix writes, we read."""
    rng = random.Random(f"read {edition.category} {edition.chosen} {seed}")
    blocks, made = [], 0
    while made < count:
        records, block = edition.block(rng, min(4, count - made))
        made += len(records)
        blocks.append((records, block))
    # The first makes the file look like ASTERIX, whatever is in the others.
    octets = FIRST + b"".join(block for _, block in blocks)
    with tempfile.TemporaryDirectory() as folder:
        raw, lines, again = (os.path.join(folder, name) for name in ("blocks.ast", "lines.ndjson", "again.ast"))
        with open(raw, "wb") as file:
            file.write(octets)
        with open(lines, "wb") as file:
            arguments = [binary, "decode", "--untyped", "--edition", f"{edition.category}:{edition.chosen}", raw]
            decoded = subprocess.run(arguments, stdout=file, stderr=subprocess.PIPE, text=True)
        if decoded.returncode or decoded.stderr:
            tally.differences.append(f"decode: {decoded.returncode} {decoded.stderr}")
        said = run(binary, "encode", lines, "-o", again)
        if said:
            tally.differences.append(f"encode: {said[:300]}")
        with open(again, "rb") as file:
            if file.read() != octets:
                tally.differences.append("encode does not give back the octets of the file")
        with open(lines) as file:
            said = [json.loads(line) for line in file]
    at, said = len(FIRST), iter(said[1:])
    for records, block in blocks:
        offset = at + 3
        for record in records:
            line, octets = next(said, {}), record.unparse().to_bytes()
            tally.records += 1
            wanted = record_of(record, edition.expansion)
            tally.values += leaves(wanted)
            if (line.get("offset"), line.get("block"), line.get("cat")) != (offset, at, edition.category):
                tally.differences.append(f"{octets.hex()}: should be at {offset} in {at}, not {line}")
            tally.differences += [f"{octets.hex()}: {told}" for told in differences(wanted, line.get("items"), "")]
            offset += len(octets)
        at += len(block)
    if next(said, None) is not None:
        tally.differences.append("there are more lines than records")


def write(edition, binary, seed, count, tally):
    """We write, and it is what libasterix writes."""
    rng = random.Random(f"write {edition.category} {edition.chosen} {seed}")
    lines, blocks, made = [], [], 0
    while made < count:
        records, block = edition.block(rng, min(4, count - made))
        made += len(records)
        for record in records:
            wanted = record_of(record, edition.expansion)
            tally.records += 1
            tally.values += leaves(wanted)
            line = {"cat": edition.category, "edition": edition.chosen, "untyped": True, "items": line_of(wanted, rng)}
            lines.append(line if len(records) == 1 and rng.random() < 0.3 else {**line, "block": len(blocks)})
        blocks.append(block)
    with tempfile.TemporaryDirectory() as folder:
        source, target = os.path.join(folder, "lines.ndjson"), os.path.join(folder, "blocks.ast")
        with open(source, "w") as file:
            file.writelines(json.dumps(line) + "\n" for line in lines)
        said = run(binary, "encode", source, "-o", target)
        if said:
            tally.differences.append(f"encode: {said[:600]}")
        with open(target, "rb") as file:
            written = [block for _, block in split(file.read())]
    if len(written) != len(blocks):
        tally.differences.append(f"{len(blocks)} blocks became {len(written)}")
    for ours, theirs in zip(written, blocks):
        if ours != theirs:
            tally.differences.append(f"{theirs.hex()} of libasterix is {ours.hex()} to us")


def do(task):
    what, index, *arguments = task
    edition, tally = EDITIONS[index], Tally()
    try:
        {"read": read, "write": write}[what](edition, *arguments, tally)
    except Exception as error:  # so that it is known where
        raise RuntimeError(f"{what} {edition.category} {edition.chosen}") from error
    return what, index, tally


EDITIONS = list(every_edition())


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--binary", default=RELEASE, metavar="PROGRAM", help="the built utm-fusion")
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--count", type=int, default=2000, help="records of each edition in each direction")
    arguments.add_argument("--jobs", type=int, default=2, help="processes")
    arguments.add_argument("--only", action="append", metavar="N[:EDITION]", help="this category or edition")
    given = arguments.parse_args()
    began = time.monotonic()
    wanted = [index for index, edition in enumerate(EDITIONS)
              if not given.only or {str(edition.category), f"{edition.category}:{edition.chosen}"} & set(given.only)]
    tasks = [(what, index, given.binary, given.seed, given.count) for index in wanted for what in ("read", "write")]
    results = {}
    with multiprocessing.Pool(given.jobs) as pool:
        for what, index, tally in pool.imap(do, tasks):
            results[what, index] = tally
            edition = EDITIONS[index]
            if what == "write":
                both = [results[way, index] for way in ("read", "write")]
                told = sum(len(tally.differences) for tally in both) or "none"
                print(f"CAT{edition.category:03} {edition.chosen:<10} {both[0].records:>6,} read {both[1].records:>6,} written "
                      f"{sum(tally.values for tally in both):>10,} values  differences: {told}", flush=True)
            for difference in tally.differences[:5]:
                print(f"  {what}: {difference[:700]}", file=sys.stderr)
    differ = sum(len(tally.differences) for tally in results.values())
    print(f"\n{len(wanted)} editions, {sum(tally.records for tally in results.values()):,} records, "
          f"{sum(tally.values for tally in results.values()):,} values, {differ:,} differences, {time.monotonic() - began:.0f} s")
    sys.exit(differ > 0)


if __name__ == "__main__":
    main()
