#!/usr/bin/env python3
"""Exchanges random records with libasterix, a codec made by others from the same specifications, and compares them item by item.

    pip install libasterix==0.36.3
    python3 exchange.py [--binary PROGRAM] [--seed N] [--count N] [--mutations N] [--jobs N] [--edition 2.1]
    python3 exchange.py [--binary PROGRAM] --capture FILE [--expected NDJSON_GZ] [--edition 2.1]

PROGRAM is a built `utm-fusion`, by default the release build. For CAT048 (edition 1.32 with its reserved expansion field, 1.13), CAT021
(2.7 and 1.5), CAT015 (1.2), CAT062 (1.21 and 1.3), CAT063 (1.7), CAT034 (1.29) and CAT065 (1.6), which are editions that both know:

* read: libasterix makes blocks of random records, `decode` reads them. Every item and every bit must be there, as the same count, and
  nothing else. What `decode` printed goes through `encode` and must come back as the same octets.
* write: this script makes lines of random values, `encode` makes ASTERIX of them, and libasterix reads it, strictly. Every count must be
  the one that is nearest to the value.
* damage: blocks of records are damaged (bits flipped; octets overwritten, put in, taken out, cut off; LEN is made to fit), and both read
  them. Both must find the same records in a block, the same end to what is readable, and the same counts in what they found. The octets
  must come back from `encode`. CAT048 gets as many blocks as `--mutations` says, each of the others a fifth.
* `--capture`: the same comparison on a recording, raw ASTERIX, with what libasterix makes of it, or with the lines that it once made
  of it (physical values under libasterix's names).

With `--edition 2.1` CAT021 is exchanged in that edition, alone and undamaged, without the items of which a part was spare then.

Where `decode` is more or less strict than libasterix, that is one of LIMITS: libasterix is made to keep the same limit, and must then
find just the same. Each is counted by itself; whatever they leave unexplained is a disagreement. The tables of ITEMS say which of our
keys is which of libasterix's; widths, signs and LSBs are libasterix's alone. Ends with 1 where anything disagrees.
"""

import argparse
import collections
import contextlib
import gzip
import itertools
import json
import multiprocessing
import os
import random
import re
import subprocess
import sys
import tempfile
import time

import asterix.generated as editions
from asterix import base

from exchange_items import ITEMS as MORE_ITEMS, SURFACE_2_1

HERE = os.path.dirname(os.path.abspath(__file__))
RELEASE = os.path.join(HERE, "../../target/release/utm-fusion")
STRICT = base.ParsingMode.StrictParsing
EDITION = "2.1" if "2.1" in sys.argv else "2.7"
BLOCKS = {15: editions.Cat_015_1_2, 34: editions.Cat_034_1_29, 48: editions.Cat_048_1_32, 65: editions.Cat_065_1_6, 62: editions.Cat_062_1_21,
          63: editions.Cat_063_1_7, 21: editions.Cat_021_2_1 if EDITION == "2.1" else editions.Cat_021_2_7}
RECORDS = {number: edition.cv_uap.cv_record for number, edition in BLOCKS.items()}
EXPANSIONS = {48: editions.Ref_048_1_13.cv_expansion, 21: editions.Ref_021_1_5.cv_expansion, 62: editions.Ref_062_1_3.cv_expansion}

# Items of CAT021 of which edition 2.1 has a part as spare bits, or another name for one.
CHANGED_SINCE_2_1 = {"040", "090", "200", "295"}
LEFT_OUT = {21: CHANGED_SINCE_2_1 if EDITION == "2.1" else set()}

# --- Which of our keys is which of libasterix's --------------------------------------------------------------------------------------

# `key=form:PATH`; an item or subfield that is a single value has no key and no path. `~1` is the first run of spare bits of an item, and
# `A+B` are values that stand side by side. Forms: none, a whole number; q, a physical value in libasterix's unit; nm and ft, the same in
# metres, kt and fpm (feet a minute) in metres a second; oct and hex, digits; address, hexadecimal in capitals; icao and ascii, characters
# of 6 and 8 bits.
UNITS = {"q": 1.0, "nm": 1852.0, "ft": 0.3048, "kt": 1852.0 / 3600.0, "fpm": 0.3048 / 60.0}

SENSOR = "ant=ANT chab=CHAB ovl=OVL msc=MSC spare=~1"
LOW_QUALITY = "spare=~1 low_quality=oct:QA4+QA2+QA1+QB4+QB2+QB1+QC4+QC2+QC1+QD4+QD2+QD1"
SUM = "m5=M5 id=ID da=DA m1=M1 m2=M2 m3=M3 mc=MC spare=~1"
POSITION = "latitude_deg=q:LAT longitude_deg=q:LON"
ALTITUDE = "spare=~1 res=RES altitude_ft=q:GA"
EM1 = "v=V g=G l=L spare=~1 em1=oct:EM1"
X_PULSES = "spare=~1 xp=XP x5=X5 xc=XC x3=X3 x2=X2 x1=X1"

EXPANSION_ITEMS = {
    "md5=MD5": {
        "sum=SUM": SUM, "pmn=PMN": "spare=~1 pin=PIN spare_2=~2 nav=NAV nat=NAT spare_3=~3 mis=MIS", "pos=POS": POSITION,
        "ga=GA": ALTITUDE, "em1=EM1": EM1, "tos_s=TOS": "q:", "xp=XP": X_PULSES,
    },
    "m5n=M5N": {
        "sum=SUM": SUM, "pmn=PMN": "spare=~1 pin=PIN spare_2=~2 nov=NOV no=NO", "pos=POS": POSITION,
        "ga=GA": ALTITUDE, "em1=EM1": EM1, "tos_s=TOS": "q:", "xp=XP": X_PULSES, "fom=FOM": "spare=~1 fom=FOM",
    },
    "m4e=M4E": ("parts", "spare=~1 foe_fri=FOEFRI"),
    "rpc=RPC": {"sco=SCO": ":", "src_db=SRC": "q:", "rw_m=RW": "nm:", "ar_m=AR": "nm:"},
    "err_m=ERR": "nm:",
    "rtc=RTC": {
        "ptl=PTL": "spare=~1 scn=SCN rc=RC ac=AC ssr=SSR psr=PSR plot_number=PLOTNR",
        "atl=ATL": ("each", ":"),
        "trn_percent=TRN": ":",
        "npp=NPP": "rho_m=nm:PREDRHO theta_deg=q:PREDTHETA"
                   " evolution_rho_start_m=nm:EVOLRHOSTART evolution_rho_end_m=nm:EVOLRHOEND"
                   " evolution_theta_start_deg=q:EVOLTHETASTART evolution_theta_end_deg=q:EVOLTHETAEND"
                   " noise_rho_start_m=nm:NOISERHOSTART noise_rho_end_m=nm:NOISERHOEND"
                   " noise_theta_start_deg=q:NOISETHETASTART noise_theta_end_deg=q:NOISETHETAEND time_s=q:PREDTIME",
        "dlk=DLK": ("each", "type=TYPE origin=ORIGIN state=STATE"),
        "lck=LCK": "ls=LS time_ms=LOCTIM",
        "tc=TC": "spare=~1 count_1=TCOUNT1 code_1=TCODE1 count_2=TCOUNT2 code_2=oct:TCODE2 count_3=TCOUNT3 code_3=oct:TCODE3",
        "tlc=TLC": "acqi=ACQI updates=TRKUPDCTR last_update_ms=LASTTRKUPD",
        "asi=ASI": ("each", "sac=SACADJS sic=SICADJS time_s=q:TIMEOFDAYSCN data_use=DATAUSE drna=DRNA drn=DRN"),
        "tes=TES": ":",
        "ir=IR": "ir=IR mode_3a_age_s=M3A",
    },
    "cpc=CPC": {
        "pnb=PNB": ":", "rpl=RPL": ("each", "type=TYPE reply_number=REPLYNBR"), "snb=SNB": ":",
        "date=DATE": "year=hex:Y1+Y2+Y3+Y4 month=hex:M1+M2 day=hex:D1+D2",
    },
    "gen48=GEN48": {
        "altm2=ALTM2": "v=V g=G l=L spare=~1 code=oct:ALTM2", "altm3=ALTM3": "v=V g=G l=L spare=~1 code=oct:ALTM3",
        "altfl=ALTFL": "v=V g=G flight_level=q:ALTFL", "rcsdb=RCSDB": "spare=~1 dbm2=q:RCSDB", "rcsm=RCSM": "spare=~1 m2=q:RCSM",
    },
}

ITEMS = {
    34: {
        "010": "sac=SAC sic=SIC",
        "000": ":",
        "030": "q:",
        "020": "azimuth_deg=q:",
        "041": "period_s=q:",
        "050": {
            "com=COM": "nogo=NOGO rdpc=RDPC rdpr=RDPR ovl_rdp=OVLRDP ovl_xmt=OVLXMT msc=MSC tsv=TSV spare=~1",
            "psr=PSR": SENSOR, "ssr=SSR": SENSOR,
            "mds=MDS": "ant=ANT chab=CHAB ovl_sur=OVLSUR msc=MSC scf=SCF dlf=DLF ovl_scf=OVLSCF ovl_dlf=OVLDLF spare=~1",
        },
        "060": {
            "com=COM": "spare=~1 red_rdp=REDRDP red_xmt=REDXMT spare_2=~2", "psr=PSR": "pol=POL red_rad=REDRAD stc=STC spare=~1",
            "ssr=SSR": "red_rad=REDRAD spare=~1", "mds=MDS": "red_rad=REDRAD clu=CLU spare=~1",
        },
        "070": ("each", "typ=TYP count=COUNT"),
        "100": "rho_start_m=nm:RHOST rho_end_m=nm:RHOEND theta_start_deg=q:THETAST theta_end_deg=q:THETAEND",
        "110": ":",
        "120": "height_m=q:HGT latitude_deg=q:LAT longitude_deg=q:LON",
        "090": "range_m=nm:RNG azimuth_deg=q:AZM",
        "RE": ("octets",),
        "SP": ("octets",),
    },
    48: {
        "010": "sac=SAC sic=SIC",
        "140": "q:",
        "020": (
            "parts",
            "typ=TYP sim=SIM rdp=RDP spi=SPI rab=RAB",
            "tst=TST err=ERR xpp=XPP me=ME mi=MI foe_fri=FOEFRI",
            "adsb_ep=ADSB/EP adsb=ADSB/VAL scn_ep=SCN/EP scn=SCN/VAL pai_ep=PAI/EP pai=PAI/VAL spare_3=~1",
            "acasxv_ep=ACASXV/EP acasxv=ACASXV/VAL poxpr_ep=POXPR/EP poxpr=POXPR/VAL",
            "poact_ep=POACT/EP poact=POACT/VAL dtfxpr_ep=DTFXPR/EP dtfxpr=DTFXPR/VAL dtfact_ep=DTFACT/EP dtfact=DTFACT/VAL spare_5=~2",
            "irmxpr_ep=IRMXPR/EP irmxpr=IRMXPR/VAL irmact_ep=IRMACT/EP irmact=IRMACT/VAL spare_6=~3",
        ),
        "040": "rho_m=nm:RHO theta_deg=q:THETA",
        "070": "v=V g=G l=L spare=~1 mode_3a=oct:MODE3A",
        "090": "v=V g=G flight_level=q:FL",
        "130": {"srl_deg=SRL": "q:", "srr=SRR": ":", "sam_dbm=SAM": "q:", "prl_deg=PRL": "q:", "pam_dbm=PAM": "q:", "rpd_m=RPD": "nm:",
                "apd_deg=APD": "q:"},
        "220": "address:",
        "240": "icao:",
        "250": ("each", "data=hex:MBDATA bds1=BDS1 bds2=BDS2"),
        "161": "spare=~1 track_number=TRN",
        "042": "x_m=nm:X y_m=nm:Y",
        "200": "speed_m_s=nm:GSP heading_deg=q:HDG",
        "170": ("parts", "cnf=CNF rad=RAD dou=DOU mah=MAH cdm=CDM", "tre=TRE gho=GHO sup=SUP tcc=TCC spare_2=~1"),
        "210": "sigma_x_m=nm:SIGX sigma_y_m=nm:SIGY sigma_v_m_s=nm:SIGV sigma_h_deg=q:SIGH",
        "030": ("codes",),
        "080": LOW_QUALITY,
        "100": "v=V g=G spare=~1 mode_c_gray=hex:MODEC spare_2=~2 low_quality=hex:QC1+QA1+QC2+QA2+QC4+QA4+QB1+QD1+QB2+QD2+QB4+QD4",
        "110": "spare=~1 height_m=ft:3DH",
        "120": {"cal=CAL": "d=D spare=~1 speed_m_s=q:CAL",
                "rds=RDS": ("each", "doppler_m_s=DOP ambiguity_m_s=AMB frequency_mhz=FRQ")},
        "230": "com=COM stat=STAT si=SI spare=~1 mssc=MSSC arc=ARC aic=AIC b1a=B1A b1b=B1B",
        "260": "hex:",
        "055": "v=V g=G l=L mode_1=MODE1",
        "050": "v=V g=G l=L spare=~1 mode_2=oct:MODE2",
        "065": "spare=~1 low_quality=QA4+QA2+QA1+QB2+QB1",
        "060": LOW_QUALITY,
        "SP": ("octets",),
        "RE": ("expansion", EXPANSION_ITEMS),
    },
    65: {
        "010": "sac=SAC sic=SIC",
        "000": ":",
        "015": ":",
        "030": "q:",
        "020": ":",
        "040": "nogo=NOGO ovl=OVL tsv=TSV pss=PSS sttn=STTN spare=~1",
        "050": ":",
        "RE": ("octets",),
        "SP": ("octets",),
    },
}
ITEMS.update(MORE_ITEMS)
if EDITION == "2.1":
    ITEMS[21] = {name: described for name, described in ITEMS[21].items() if name not in LEFT_OUT[21]}
    ITEMS[21]["271"] = SURFACE_2_1


class Wrong(Exception):
    """A line says what it may not say: the path, and why."""


def must(condition, path, why):
    if not condition:
        raise Wrong(f"{path}: {why}")


def any_count(rng, bits):
    """So many bits, often the least and the greatest that they hold, signed or not."""
    top = 1 << bits
    return rng.choice([0, 1, top - 1, top // 2, top // 2 - 1]) % top if rng.random() < 0.4 else rng.getrandbits(bits)


def any_octets(rng, most=20):
    """Octets behind a length octet."""
    length = 254 if rng.random() < 0.01 else rng.randint(0, most)
    return rng.randbytes(length)


def content_of(spec):
    """What an element holds; where that depends on other items, bits."""
    return getattr(spec.cv_rule, "cv_content", base.ContentRaw)


def any_repetitions(rng):
    return rng.randint(6, 60) if rng.random() < 0.02 else rng.randint(0, 5)


# --- Our lines: from values to counts, and random values with their counts -------------------------------------------------------------

# Each of these knows a part of an item, made from the table and from libasterix's description of the part. `read` puts the counts of
# `value` into `counts`, by libasterix's paths, with a mark where an item or subfield is that may be empty; `make` gives a random value
# and puts its counts there.

class Value:
    """A number or a text."""

    def __init__(self, form, names, specs):
        self.form, self.names, self.widths = form, names, [spec.cv_bit_size for spec in specs]
        self.bits = sum(self.widths)
        self.lsb, self.signed = None, False
        content = content_of(specs[0])
        if form in UNITS:
            self.lsb = content.cv_lsb * UNITS[form]
            self.signed = content.cv_signedness is base.Signed
        elif issubclass(content, base.ContentQuantity):
            assert content.cv_lsb == 1 and content.cv_signedness is base.Unsigned, "a whole number has no LSB"
        elif issubclass(content, base.ContentInteger):
            assert content.cv_signedness is base.Unsigned

    def put(self, count, path, counts):
        for name, width in zip(reversed(self.names), reversed(self.widths)):
            counts[path + name] = count & ((1 << width) - 1)
            count >>= width

    def read(self, value, path, counts):
        self.put(self.count(value, path + "+".join(self.names)), path, counts)

    def count(self, value, path):
        if self.lsb is not None:
            must(type(value) in (int, float), path, f"{value!r} is no number")
            count = round(value / self.lsb)
            low = -(1 << (self.bits - 1)) if self.signed else 0
            must(low <= count < low + (1 << self.bits), path, f"{value!r} is out of range")
            return count % (1 << self.bits)
        if self.form == "":
            must(type(value) is int and 0 <= value < 1 << self.bits, path, f"{value!r} is no whole number of {self.bits} bits")
            return value
        if self.form == "icao":
            return self.characters(value, path)
        if self.form == "ascii":
            return self.ascii(value, path)
        bits, digits = {"oct": (3, "01234567"), "hex": (4, "0123456789abcdef"), "address": (4, "0123456789ABCDEF")}[self.form]
        must(isinstance(value, str) and len(value) * bits == self.bits and set(value) <= set(digits), path, f"{value!r} are no digits")
        return int(value, len(digits))

    def characters(self, value, path):
        """Characters, or octets where one of the codes is no character."""
        if isinstance(value, dict):
            must(set(value) == {"hex"} and len(value["hex"]) * 4 == self.bits, path, f"{value!r} is no text")
            count = int(value["hex"], 16)
            codes = [count >> at & 63 for at in range(0, self.bits, 6)]
            must(not all(1 <= code <= 26 or code == 32 or 48 <= code <= 57 for code in codes), path, "could be printed as a text")
            return count
        must(isinstance(value, str) and len(value) * 6 == self.bits, path, f"{value!r} is no text")
        must(all(character in " 0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ" for character in value), path, f"{value!r} is no text")
        count = 0
        for character in value:
            count = count << 6 | ord(character) & 63
        return count

    def ascii(self, value, path):
        """Printable characters, or octets where one of them is none."""
        if isinstance(value, dict):
            octets = bytes.fromhex(value["hex"])
            must(set(value) == {"hex"} and len(octets) * 8 == self.bits, path, f"{value!r} is no text")
            must(not all(32 <= octet <= 126 for octet in octets), path, "could be printed as a text")
        else:
            octets = value.encode("ascii")
            must(len(octets) * 8 == self.bits and all(32 <= octet <= 126 for octet in octets), path, f"{value!r} is no text")
        return int.from_bytes(octets, "big")

    def make(self, rng, path, counts):
        count = any_count(rng, self.bits)
        if self.form == "ascii":
            octets = bytes(rng.randint(32, 126) for _ in range(self.bits // 8)) if rng.random() < 0.8 else rng.randbytes(self.bits // 8)
            self.put(int.from_bytes(octets, "big"), path, counts)
            return octets.decode("ascii") if max(octets) < 128 and rng.random() < 0.5 else {"hex": octets.hex()}
        if self.lsb is not None:
            low = -(1 << (self.bits - 1)) if self.signed else 0
            value = ((count - low) % (1 << self.bits) + low + rng.choice([0.0, rng.uniform(-0.49, 0.49)])) * self.lsb
        elif self.form == "":
            value = count
        elif self.form == "icao":
            if rng.random() < 0.8:
                text = "".join(rng.choices(" 0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ", k=rng.randint(0, 8)))
                value, count = text, self.characters(text.ljust(8), path)
            else:
                value = {"hex": f"{count:012x}"}
        else:
            value = f"{count:0{self.bits // 3}o}" if self.form == "oct" else f"{count:0{self.bits // 4}x}"
            value = value.upper() if rng.random() < 0.5 else value
        self.put(count, path, counts)
        return value


class Fields:
    """Values by key; spare bits are told where they are not zero."""

    def __init__(self, values):
        self.values = values

    def read(self, value, path, counts, others=()):
        must(isinstance(value, dict), path, f"{value!r} is no object")
        unknown = set(value) - set(self.values) - set(others)
        must(not unknown, path, f"nobody knows {sorted(unknown)}")
        for key, field in self.values.items():
            if not key.startswith("spare"):
                must(key in value, path, f"has no `{key}`")
            elif key not in value:
                field.put(0, path, counts)
                continue
            else:
                must(value[key] != 0, path, f"`{key}` is 0")
            field.read(value[key], path, counts)

    def make(self, rng, path, counts):
        made = {}
        for key, field in rng.sample(list(self.values.items()), len(self.values)):
            if key.startswith("spare") and rng.random() < 0.7:
                field.put(0, path, counts)
            else:
                made[key] = field.make(rng, path, counts)
        return made


class Parts:
    """An extended item: fields of several octets in one object."""

    def __init__(self, parts, sizes):
        self.parts = parts
        self.sizes = sizes  # octets of each

    def read(self, value, path, counts):
        must(isinstance(value, dict), path, f"{value!r} is no object")
        value = dict(value)
        more = value.pop("more", None)
        sent = [any(key in value for key in part.values) for part in self.parts]
        length = 1 + max((index for index, there in enumerate(sent) if there), default=0)
        keys = {key for part in self.parts[:length] for key in part.values}
        for part in self.parts[:length]:
            part.read(value, path, counts, keys)
        counts[path + "octets"] = sum(self.sizes[:length])
        if more is not None:
            must(length == len(self.parts), path, "has `more` before its end")
            counts[path + "octets"] += len(more) // 2
            counts[path + "more"] = more

    def make(self, rng, path, counts):
        made = {}
        length = rng.randint(1, len(self.parts))
        for part in self.parts[:length]:
            made.update(part.make(rng, path, counts))
        counts[path + "octets"] = sum(self.sizes[:length])
        return made


class Register:
    """A register of 56 bits and its number of two digits, which are one value to libasterix."""

    WIDTHS = {"data": 56, "bds1": 4, "bds2": 4}

    def read(self, value, path, counts):
        must(isinstance(value, dict) and set(value) == set(self.WIDTHS), path, f"{value!r} is no register")
        must(len(value["data"]) == 14, path, f"{value!r} is no register")
        counts[path] = int(value["data"], 16) << 8 | value["bds1"] << 4 | value["bds2"]

    def make(self, rng, path, counts):
        made = {"data": f"{any_count(rng, 56):014x}", "bds1": any_count(rng, 4), "bds2": any_count(rng, 4)}
        self.read(made, path, counts)
        return made


class Codes:
    """Codes of 7 bits."""

    def read(self, value, path, counts):
        must(isinstance(value, list) and value, path, f"{value!r} is no array of codes")
        must(all(type(code) is int and 0 <= code < 128 for code in value), path, f"{value!r} is no array of codes")
        counts[path + "n"] = len(value)
        counts.update((f"{path}{index}/", code) for index, code in enumerate(value))

    def make(self, rng, path, counts):
        made = [any_count(rng, 7) for _ in range(rng.choice([1, 2, 3, 4, 5, 6, rng.randint(7, 16)]))]
        self.read(made, path, counts)
        return made


class Each:
    """The same part several times."""

    def __init__(self, part, counted):
        self.part = part
        self.counted = counted  # or else FX says whether another follows

    def read(self, value, path, counts):
        must(isinstance(value, list), path, f"{value!r} is no array")
        counts[path + "n"] = len(value)
        for index, part in enumerate(value):
            self.part.read(part, f"{path}{index}/", counts)

    def make(self, rng, path, counts):
        length = counts[path + "n"] = any_repetitions(rng) if self.counted else rng.randint(1, 16)
        return [self.part.make(rng, f"{path}{index}/", counts) for index in range(length)]


class Compound:
    """Subfields, of which any may be there."""

    def __init__(self, subfields):
        self.subfields = subfields  # our key: (libasterix's name, part)

    def read(self, value, path, counts):
        must(isinstance(value, dict), path, f"{value!r} is no object")
        value = dict(value)
        if "primary" in value:
            counts[path + "primary"] = value.pop("primary")
        must(set(value) <= set(self.subfields), path, f"nobody knows {sorted(set(value) - set(self.subfields))}")
        counts[path] = "subfields"
        for key, inner in value.items():
            name, part = self.subfields[key]
            part.read(inner, f"{path}{name}/", counts)

    def make(self, rng, path, counts):
        counts[path] = "subfields"
        share = rng.choice([0.1, 0.4, 0.4, 1.0])
        chosen = [(key, *subfield) for key, subfield in self.subfields.items() if rng.random() < share]
        rng.shuffle(chosen)
        return {key: part.make(rng, f"{path}{name}/", counts) for key, name, part in chosen}


class Octets:
    """An item whose octets nobody explains, after a length octet."""

    def read(self, value, path, counts):
        must(isinstance(value, str) and int(value[:2], 16) * 2 == len(value), path, f"{value!r} is no item with its length")
        counts[path] = value[2:]

    def make(self, rng, path, counts):
        octets = any_octets(rng)
        counts[path] = octets.hex()
        return bytes([len(octets) + 1]).hex() + octets.hex()


class Expansion(Compound):
    """The reserved expansion field, or octets where it is none of its edition."""

    def __init__(self, subfields, spec):
        super().__init__(subfields)
        self.spec = spec

    def read(self, value, path, counts):
        if isinstance(value, str):
            Octets().read(value, path, counts)
        else:
            super().read(value, path, counts)

    def make(self, rng, path, counts):
        while rng.random() < 0.8:
            there = {}
            made = super().make(rng, path, there)
            # With at most five of each that is repeated, all of it together is shorter than 254 octets.
            if all(count <= 5 for name, count in there.items() if name.endswith("/n")):
                counts.update(there)
                return made
        octets = any_octets(rng)
        counts.update(expansion_counts(self.spec, octets, path))
        return bytes([len(octets) + 1]).hex() + octets.hex()


def variation(spec):
    """The structure of an item of libasterix."""
    return spec.cv_rule.cv_variation


def members(spec, path=""):
    """The values in a structure of fixed length, `path: specification`; spare bits as `~1`, `~2`, …"""
    if issubclass(spec, base.Element):
        return {path: spec}
    assert issubclass(spec, base.Group)
    return of_items([item for item, _ in spec.cv_items_list], path, itertools.count(1))


def of_items(items, path, spares):
    found = {}
    for item in items:
        if issubclass(item, base.Spare):
            found[f"{path}~{next(spares)}"] = item
        else:
            inner = variation(item.cv_non_spare)
            name = path + item.cv_non_spare.cv_name
            found.update(members(inner, name if issubclass(inner, base.Element) else name + "/"))
    return found


class SpareBits:
    """Looks like the specification of a whole number."""
    cv_content = base.ContentRaw

    def __init__(self, spec):
        self.cv_bit_size, self.cv_rule = spec.cv_bit_size, self


def fields(text, found):
    """The part that a text of the table describes; each member that libasterix has must be in it, once."""
    values = {}
    left = dict(found)
    for token in text.split():
        key, equals, source = token.rpartition("=")
        form, _, path = source.rpartition(":")
        specs = [left.pop(name) for name in path.split("+")]
        specs = [SpareBits(spec) if issubclass(spec, base.Spare) else spec for spec in specs]
        values[key] = Value(form, path.split("+"), specs)
    assert not left, f"{text} says nothing of {sorted(left)}"
    return values[""] if "" in values else Fields(values)


def octets_of(items):
    """Octets of a part of an extended item."""
    bits = [None if item is None else item[0] for item in items]
    return (sum(1 if item is None else bits_of(item) for item in bits) + 7) // 8


def bits_of(item):
    if issubclass(item, base.Spare):
        return item.cv_bit_size
    return sum(spec.cv_bit_size for spec in members(variation(item.cv_non_spare)).values())


def part(described, spec, category=None):
    """What the table and libasterix say of an item or of a part of it."""
    if isinstance(described, str):
        return fields(described, members(spec))
    if isinstance(described, dict):
        return Compound(subfields(described, spec.cv_items_list))
    kind, *inner = described
    if kind == "parts":
        spares = itertools.count(1)
        octets = [[item[0] for item in octet if item is not None] for octet in spec.cv_items_list]
        sizes = [octets_of(octet) for octet in spec.cv_items_list]
        return Parts([fields(text, of_items(octet, "", spares)) for text, octet in zip(inner, octets, strict=True)], sizes)
    if kind == "each":
        assert issubclass(spec, base.Repetitive) and spec.cv_rep_bytes in (1, None)
        return Each(part(inner[0], spec.cv_variation), spec.cv_rep_bytes == 1)
    if kind == "register":
        assert issubclass(spec, base.Element) and spec.cv_bit_size == 64
        return Register()
    if kind == "codes":
        assert issubclass(spec, base.Repetitive) and spec.cv_rep_bytes is None and spec.cv_variation.cv_bit_size == 7
        return Codes()
    if kind == "expansion":
        expansion = EXPANSIONS[category]
        return Expansion(subfields(inner[0], expansion.cv_items_list), expansion)
    assert kind == "octets" and issubclass(spec, base.Explicit)
    return Octets()


def subfields(described, listed):
    specs = {spec.cv_name: variation(spec) for spec in listed if spec is not None}
    named = dict(key.split("=") for key in described)
    assert set(named.values()) == set(specs), f"{sorted(set(named.values()) ^ set(specs))}"
    return {key: (name, part(described[f"{key}={name}"], specs[name])) for key, name in named.items()}


OURS = {}
for number, table in ITEMS.items():
    specs = {item.cv_non_spare.cv_name: variation(item.cv_non_spare)
             for item in RECORDS[number].cv_items_list if issubclass(item, base.UapItem)}
    assert set(specs) - set(table) == LEFT_OUT.get(number, set())
    OURS[number] = {name: part(described, specs[name], number) for name, described in table.items()}


INDEX = re.compile(r"/[0-9]+(?=/)")


def kinds(part, path):
    """Every path that a value may have, with `*` for a number in a series."""
    match part:
        case Value():
            return [path + name for name in part.names]
        case Fields():
            return [kind for field in part.values.values() for kind in kinds(field, path)]
        case Parts():
            return [path + "octets"] + [kind for octet in part.parts for kind in kinds(octet, path)]
        case Each():
            return [path + "n"] + kinds(part.part, path + "*/")
        case Codes():
            return [path + "n", path + "*/"]
        case Compound():
            return [path] + [kind for name, inner in part.subfields.values() for kind in kinds(inner, f"{path}{name}/")]
        case Octets() | Register():
            return [path]


KINDS = {number: [kind for name, part in items.items() for kind in kinds(part, f"{name}/")] for number, items in OURS.items()}


def counts_of_line(line):
    """The counts in a line of `decode`."""
    counts = {}
    others = set(line) - {"time", "offset", "block", "cat", "edition", "sac", "sic", "items", "fspec"}
    must(not others, "line", f"has {sorted(others)}")
    source = line["items"].get("010", {})
    must((line.get("sac"), line.get("sic")) == (source.get("sac"), source.get("sic")), "line", "sac and sic are not those of 010")
    for name, value in line["items"].items():
        if name in LEFT_OUT.get(line["cat"], ()):
            continue
        OURS[line["cat"]][name].read(value, f"{name}/", counts)
    if "fspec" in line:
        counts["FSPEC/"] = line["fspec"]
    return counts


# --- libasterix: counts of what it read, random records, limits ------------------------------------------------------------------------

def counts_of_record(record):
    """The counts in a record that libasterix read."""
    counts = {}
    category = next(number for number, spec in RECORDS.items() if isinstance(record, spec))
    for name, item in record.items_regular.items():
        if name in LEFT_OUT.get(category, ()):
            continue
        if name == "RE" and category in EXPANSIONS:
            counts.update(expansion_counts(EXPANSIONS[category], item.arg.arg.get_bytes(), "RE/"))
        else:
            collect(item.arg.arg, f"{name}/", counts)
    octets = record.unparse().to_bytes()
    length = next(index for index, octet in enumerate(octets) if octet & 1 == 0) + 1
    if length > 1 and octets[length - 1] == 0:
        counts["FSPEC/"] = octets[:length].hex()
    return counts


def collect(found, path, counts):
    if isinstance(found, base.Element):
        counts[path] = found.as_uint()
    elif isinstance(found, base.Group):
        collect_items(found.arg, path, counts)
    elif isinstance(found, base.Extended):
        collect_items([item for octet in found.arg for item in octet if item is not None], path, counts)
        counts[path + "octets"] = len(found.unparse().to_bytes())
        if hasattr(found, "more"):
            counts[path + "more"] = found.more.hex()
    elif isinstance(found, base.Repetitive):
        counts[path + "n"] = len(found.arg)
        for index, inner in enumerate(found.arg):
            collect(inner, f"{path}{index}/", counts)
    elif isinstance(found, base.Compound):
        counts[path] = "subfields"
        octets = found.unparse().to_bytes()
        primary = octets[:next(index for index, octet in enumerate(octets) if octet & 1 == 0) + 1]
        if len(primary) > 1 and primary[-1] == 0:
            counts[path + "primary"] = primary.hex()
        for name, subfield in found.arg.items():
            collect(subfield.arg.arg, f"{path}{name}/", counts)
    else:
        counts[path] = found.get_bytes().hex()


def collect_items(items, path, counts):
    spares = itertools.count(1)
    for item in items:
        if isinstance(item, base.Spare):
            counts[f"{path}~{next(spares)}"] = item.as_uint()
        else:
            inner = item.arg.arg.arg
            name = path + item.cv_non_spare.cv_name
            if isinstance(inner, base.Element):
                counts[name] = inner.as_uint()
            else:
                collect(inner, name + "/", counts)


def expansion_counts(spec, octets, path):
    """The counts in the contents of a reserved expansion field; its octets where libasterix cannot read them. Extended items may be
    longer, as everywhere."""
    with keeping("extension"):
        result = spec._parse(base.Bits.from_bytes(octets))
    if isinstance(result, ValueError) or len(result[1]):
        return {path: octets.hex()}
    counts = {path: "subfields"}
    for name, subfield in result[0].arg.items():
        collect(subfield.arg.arg, f"{path}{name}/", counts)
    return counts


def any_argument(rng, spec):
    """What libasterix makes a random part from."""
    if issubclass(spec, base.Element):
        content = content_of(spec)
        if issubclass(content, base.ContentString) and content.cv_string_type is base.StringICAO and rng.random() < 0.7:
            text = "".join(rng.choices(" 0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ", k=8))
            return base.StringICAO.from_string(48, text)
        return any_count(rng, spec.cv_bit_size)
    if issubclass(spec, base.Group):
        return tuple(any_item(rng, item) for item, _ in spec.cv_items_list)
    if issubclass(spec, base.Extended):
        octets = spec.cv_items_list[:rng.randint(1, len(spec.cv_items_list))]
        return [tuple(None if item is None else any_item(rng, item[0]) for item in octet) for octet in octets]
    if issubclass(spec, base.Repetitive):
        length = any_repetitions(rng) if spec.cv_rep_bytes else rng.choice([1, 2, 3, 4, 5, 6, rng.randint(7, 16)])
        return [any_argument(rng, spec.cv_variation) for _ in range(length)]
    if issubclass(spec, base.Compound):
        share = rng.choice([0.1, 0.4, 0.4, 1.0])
        return {inner.cv_name: any_argument(rng, variation(inner)) for inner in spec.cv_items_list
                if inner is not None and rng.random() < share}
    return any_octets(rng)


def any_expansion(rng, spec):
    """Contents of a reserved expansion field."""
    while rng.random() < 0.8:
        share = rng.choice([0.1, 0.4, 0.4, 1.0])
        made = spec.create({inner.cv_name: any_argument(rng, variation(inner)) for inner in spec.cv_items_list
                            if inner is not None and rng.random() < share}).unparse().to_bytes()
        if len(made) <= 254:
            return made
    return any_octets(rng)


def any_item(rng, item):
    if issubclass(item, base.Spare):
        return 0 if rng.random() < 0.7 else any_count(rng, item.cv_bit_size)
    return any_argument(rng, variation(item.cv_non_spare))


def any_record(rng, category):
    spec, items = RECORDS[category], {}
    share = rng.choice([0.1, 0.4, 0.4, 0.4, 1.0])
    for item in spec.cv_items_list:
        if issubclass(item, base.UapItem) and item.cv_non_spare.cv_name in OURS[category] and rng.random() < share:
            name = item.cv_non_spare.cv_name
            expansion = name == "RE" and EXPANSIONS.get(category)
            items[name] = any_expansion(rng, expansion) if expansion else any_argument(rng, variation(item.cv_non_spare))
    return spec.create(items)


def any_block(rng, category, most=4):
    records = [any_record(rng, category) for _ in range(rng.randint(1, most))]
    return BLOCKS[category].create(records).unparse().to_bytes(), len(records)


# Where `decode` is meant to differ from libasterix's strict reading, and libasterix made to keep the same limit.
LIMITS = {
    "padding": "an FSPEC with more octets than the edition has items for, up to 8, is read where these announce nothing",
    "extension": "an extended item with more octets than the edition describes, up to 16, is read",
}
MAX_FSPEC, MAX_CHAIN = 8, 16
kept = set()
parse_extended = base.Extended._parse.__func__


def limited_extended(spec, bits):
    if any(octets_of(part) != 1 for part in spec.cv_items_list) or spec.cv_items_list[-1][-1] is not None:
        return parse_extended(spec, bits)
    octets = bits.take(min(len(bits), 8 * MAX_CHAIN)).to_bytes() if "extension" in kept else b""
    described = len(spec.cv_items_list)
    length = next((index for index, octet in enumerate(octets) if octet & 1 == 0), -1) + 1
    if length <= described:
        return parse_extended(spec, bits)
    ended = octets[:described - 1] + bytes([octets[described - 1] & 0xFE])
    found, _ = parse_extended(spec, base.Bits.from_bytes(ended))
    found.bs, found.more = bits.take(8 * length), octets[described:length]
    return found, bits.drop(8 * length)


base.Extended._parse = classmethod(limited_extended)


@contextlib.contextmanager
def keeping(*limits):
    before = set(kept)
    kept.update(limits)
    try:
        yield
    finally:
        kept.clear()
        kept.update(before)


def records_of(category, octets, *limits):
    """What libasterix reads from the contents of a block: records up to the first that it refuses, and why it does."""
    spec = RECORDS[category]
    records, rest = [], base.Bits.from_bytes(octets)
    with keeping(*limits):
        most = spec.cv_fspec_max_bytes
        spec.cv_fspec_max_bytes = MAX_FSPEC if "padding" in kept else most
        try:
            while len(rest):
                try:
                    result = spec.parse(STRICT, rest)
                except TypeError:  # it looks for the item of an FRN that is beyond its list
                    result = ValueError("invalid FRN")
                if isinstance(result, ValueError):
                    return records, str(result)
                record, rest = result
                records.append(record)
        finally:
            spec.cv_fspec_max_bytes = most
    return records, None


# --- The comparison --------------------------------------------------------------------------------------------------------------------

class Tally:
    """What was compared, and what was not the same."""

    def __init__(self):
        self.numbers = collections.Counter()
        self.paths = set()
        self.disagreements = []

    def disagree(self, octets, what):
        self.disagreements.append(f"{octets.hex()}: {what}")

    def compare(self, octets, theirs, ours):
        """Two sets of counts of the record with these octets."""
        self.numbers["records"] += 1
        self.numbers["values"] += len(theirs)
        self.numbers["items"] += len({path.split("/")[0] for path in theirs})
        self.paths.update(theirs)
        if theirs != ours:
            paths = [path for path in sorted(theirs.keys() | ours.keys()) if theirs.get(path) != ours.get(path)]
            told = [f"{path.rstrip('/')} is {theirs.get(path)} to libasterix, {ours.get(path)} to us" for path in paths[:3]]
            self.disagree(octets, "; ".join(told + ["…"] * (len(paths) > 3)))

    def compare_line(self, octets, theirs, line):
        try:
            self.compare(octets, theirs, counts_of_line(line))
        except (Wrong, KeyError, ValueError) as error:
            self.disagree(octets, f"{type(error).__name__}: {error}")

    def add(self, other):
        self.numbers.update(other.numbers)
        self.paths |= other.paths
        self.disagreements.extend(other.disagreements)


def run(*command):
    """Standard error of a run of the program, empty where all was well."""
    done = subprocess.run(command, capture_output=True, text=True)
    return done.stderr if done.returncode == 0 else f"exit code {done.returncode}: {done.stderr}"


def split(octets):
    """(offset, block) of each block."""
    offset = 0
    while offset < len(octets):
        length = int.from_bytes(octets[offset + 1:offset + 3], "big")
        assert length >= 3 and offset + length <= len(octets)
        yield offset, octets[offset:offset + length]
        offset += length


FIRST = bytes([48, 0, 6, 0x80, 25, 7])


class Files:
    """A file of blocks, the lines that `decode` prints, and the blocks that `encode` makes of those.

    Before the blocks stands one that makes the file look like ASTERIX, whatever is in the others."""

    def __init__(self, binary, octets, tally, lead=FIRST):
        octets = lead + octets
        with tempfile.TemporaryDirectory() as folder:
            raw, lines, again = (os.path.join(folder, name) for name in ("blocks.ast", "lines.ndjson", "again.ast"))
            with open(raw, "wb") as file:
                file.write(octets)
            with open(lines, "wb") as file:
                decoded = subprocess.run([binary, "decode", "--edition", EDITION, raw], stdout=file, stderr=subprocess.PIPE, text=True)
            self.said = decoded.stderr
            assert decoded.returncode in (0, 4), decoded.stderr  # 4: some of it cannot be read
            encoded = run(binary, "encode", lines, "-o", again)
            if encoded:
                tally.disagree(b"", f"encode: {encoded}")
            with open(again, "rb") as file:
                if file.read() != octets:
                    tally.disagree(b"", "encode does not give back the octets of the file")
            with open(lines) as file:
                self.lines = collections.defaultdict(list)
                for line in file:
                    line = json.loads(line)
                    self.lines[line["block"]].append(line)
            self.start = len(lead)

    def block(self, offset):
        """(records, fault) of the block that begins there."""
        lines = self.lines.pop(self.start + offset, [])
        records = [line for line in lines if "items" in line]
        faults = [line["error"] for line in lines if "error" in line]
        assert len(faults) < 2 and (not faults or "error" in lines[-1])
        return records, faults[0] if faults else None


def compare_block(tally, block, records, lines):
    """Records that libasterix read and lines of the same number."""
    at = 3
    for record, line in zip(records, lines, strict=True):
        octets = record.unparse().to_bytes()
        if (line["offset"] - line["block"], line["cat"]) != (at, block[0]):
            tally.disagree(octets, f"is at {at} in its block, `decode` says {line['offset'] - line['block']}")
        tally.compare_line(octets, counts_of_record(record), line)
        at += len(octets)


def read(binary, category, seed, count):
    """libasterix writes, we read."""
    rng, tally = random.Random(f"read {category} {seed}"), Tally()
    blocks, made = [], 0
    while made < count:
        block, records = any_block(rng, category, min(4, count - made))
        blocks.append(block)
        made += records
    octets = b"".join(blocks)
    files = Files(binary, octets, tally)
    if files.said:
        tally.disagree(b"", f"decode: {files.said}")
    for offset, block in split(octets):
        records, refused = records_of(category, block[3:])
        assert refused is None, "libasterix refuses what it wrote"
        lines, fault = files.block(offset)
        if fault or len(lines) != len(records):
            tally.disagree(block, f"libasterix has {len(records)} records, we have {len(lines)} and {fault}")
        else:
            compare_block(tally, block, records, lines)
    return tally


def write(binary, category, seed, count):
    """We write, libasterix reads."""
    rng, tally = random.Random(f"write {category} {seed}"), Tally()
    lines, blocks, made = [], [], 0
    while made < count:
        expected = []
        for _ in range(rng.randint(1, min(4, count - made))):
            counts, items = {}, {}
            share = rng.choice([0.1, 0.4, 0.4, 0.4, 1.0])
            names = [name for name in OURS[category] if rng.random() < share]
            for name in rng.sample(names, len(names)):
                items[name] = OURS[category][name].make(rng, f"{name}/", counts)
            expected.append(counts)
            line = {"cat": category, "items": items}
            lines.append(line if len(expected) == 1 and rng.random() < 0.3 else {**line, "block": len(blocks)})
            if "block" not in lines[-1]:
                break
        blocks.append(expected)
        made += len(expected)
    with tempfile.TemporaryDirectory() as folder:
        source, target = os.path.join(folder, "lines.ndjson"), os.path.join(folder, "blocks.ast")
        with open(source, "w") as file:
            file.writelines(json.dumps(line) + "\n" for line in lines)
        said = run(binary, "encode", "--edition", EDITION, source, "-o", target)
        if said:
            tally.disagree(b"", f"encode: {said}")
        with open(target, "rb") as file:
            written = [block for _, block in split(file.read())]
    if len(written) != len(blocks):
        tally.disagree(b"", f"{len(blocks)} blocks became {len(written)}")
    for block, expected in zip(written, blocks):
        records, refused = records_of(category, block[3:])
        if block[0] != category or refused or len(records) != len(expected):
            tally.disagree(block, f"libasterix refuses it: {refused}, {len(records)} records of {len(expected)}")
            continue
        for record, counts in zip(records, expected):
            tally.compare(record.unparse().to_bytes(), counts_of_record(record), counts)
    return tally


def damaged(rng, block):
    """A block with some of its octets changed; LEN fits."""
    octets = bytearray(block[3:])
    for _ in range(rng.choice([1, 1, 1, 2, 3])):
        at = rng.randrange(len(octets)) if octets else 0
        # Half of the damage is at the front, where FSPEC and lengths are.
        at = min(at, rng.randrange(8)) if rng.random() < 0.5 else at
        match rng.randrange(8 if octets else 1):
            case 0:
                octets[at:at] = rng.randbytes(rng.randint(1, 4))
            case 1 | 2:
                octets[at] ^= 1 << rng.randrange(8)
            case 3:
                octets[at] = rng.choice([0x00, 0x01, 0x80, 0xFE, 0xFF, rng.randrange(256)])
            case 4:
                del octets[at:at + rng.randint(1, 4)]
            case 5:
                del octets[at:]
            case 6:
                octets[at:at] = octets[rng.randrange(len(octets)):][:rng.randint(1, 30)]
            case 7:
                # A chain of octets that goes on: of an FSPEC or an extended item, or whatever is there.
                octet = rng.choice([0x01, 0x01, 0xFF, None])
                octets[at:at] = bytes(octet or rng.randrange(256) | 1 for _ in range(rng.randint(1, 20)))
    return bytes([block[0]]) + (len(octets) + 3).to_bytes(2, "big") + octets


def starts_of(records):
    """Where records begin in their block."""
    return list(itertools.accumulate((len(record.unparse()) // 8 for record in records), initial=3))[:len(records)]


def damage(binary, category, seed, count):
    """Damaged blocks, read by both."""
    rng, tally = random.Random(f"damage {category} {seed}"), Tally()
    pool = [any_block(rng, category, 3)[0] for _ in range(count // 20 + 20)]
    blocks = [damaged(rng, rng.choice(pool)) for _ in range(count)]
    octets = b"".join(blocks)
    files = Files(binary, octets, tally)
    numbers = tally.numbers
    for offset, block in split(octets):
        lines, fault = files.block(offset)
        ours = [line["offset"] - line["block"] for line in lines], fault is None
        records, refused = records_of(category, block[3:])
        numbers["blocks"] += 1
        numbers["refused by both" if refused and fault else "read by both" if not refused and not fault else "differently"] += 1
        if (starts_of(records), refused is None) != ours:
            more = len(lines) > len(records) or refused and not fault
            kind = "read, which a strict reading refuses" if more else "refused, which a strict reading has"
            for limits in (limits for size in (1, 2, 3) for limits in itertools.combinations(LIMITS, size)):
                records, refused = records_of(category, block[3:], *limits)
                if (starts_of(records), refused is None) == ours:
                    numbers["limit: " + ", ".join(limits)] += 1
                    break
            else:
                numbers["unexplained: " + kind] += 1
                tally.disagree(block, f"{kind}: libasterix has {len(records)} and {refused}, we have {len(lines)} and {fault}")
                continue
        compare_block(tally, block, records, lines)
    return tally


# --- Recordings ------------------------------------------------------------------------------------------------------------------------

def counts_of_values(spec, value, path, counts):
    """The counts in physical values under libasterix's names."""
    if issubclass(spec, base.Element):
        content, bits = content_of(spec), spec.cv_bit_size
        if isinstance(value, dict):  # of a text that none is
            value = value["raw"]
        elif issubclass(content, base.ContentQuantity):
            value = round(value / content.cv_lsb) % (1 << bits)
        elif isinstance(value, str):
            value = content.cv_string_type.from_string(bits, value)
        counts[path] = value
    elif issubclass(spec, base.Repetitive):
        counts[path + "n"] = len(value)
        for index, inner in enumerate(value):
            counts_of_values(spec.cv_variation, inner, f"{path}{index}/", counts)
    elif issubclass(spec, base.Compound):
        counts[path] = "subfields"
        for name, inner in value.items():
            counts_of_values(variation(spec.cv_items_dict[name]), inner, f"{path}{name}/", counts)
    else:
        listed, groups = spec.cv_items_list, [value]
        if issubclass(spec, base.Extended):
            listed, groups = itertools.chain.from_iterable(listed), value["_groups"]
            counts[path + "octets"] = sum(octets_of(part) for part in spec.cv_items_list[:len(groups)])
        items = [item[0] for item in listed if item is not None and not issubclass(item[0], base.Spare)]
        inside = {item.cv_non_spare.cv_name: variation(item.cv_non_spare) for item in items}
        for name, inner in itertools.chain.from_iterable(group.items() for group in groups):
            element = issubclass(inside[name], base.Element)
            counts_of_values(inside[name], inner, path + name if element else f"{path}{name}/", counts)


def once_read(category, name, value, counts):
    """The counts of an item as libasterix once wrote it down."""
    if isinstance(value, dict) and "_hex" in value:
        octets = bytes.fromhex(value["_hex"])
        expansion = EXPANSIONS.get(category)
        counts.update(expansion_counts(expansion, octets, f"{name}/") if expansion and name == "RE" else {f"{name}/": octets.hex()})
    else:
        counts_of_values(variation(RECORDS[category].cv_items_dict[name]), value, f"{name}/", counts)


def capture(binary, path, expected, category):
    """The blocks of a category of a recording, against libasterix or against what it once read there."""
    tally = Tally()
    with open(path, "rb") as file:
        octets = file.read()
    files = Files(binary, octets, tally, b"")
    if expected:
        with gzip.open(expected, "rt") as file:
            once = collections.defaultdict(list)
            for line in file:
                record = json.loads(line)
                if record["cat"] == category and "items" in record:
                    once[record["off"]].append(record)
    for offset, block in split(octets):
        lines, fault = files.block(offset)
        if block[0] != category:
            continue
        if not expected:
            records, refused = records_of(category, block[3:], *LIMITS)
            if len(records) != len(lines) or (refused is None) != (fault is None):
                tally.disagree(block, f"libasterix has {len(records)} and {refused}, we have {len(lines)} and {fault}")
            else:
                compare_block(tally, block, records, lines)
            continue
        records = once.pop(offset, [])
        if len(records) != len(lines) or fault:
            tally.disagree(block, f"{len(records)} records are expected, we have {len(lines)} and {fault}")
            continue
        for record, line in zip(records, lines):
            theirs = {}
            for name, value in record["items"].items():
                if name not in LEFT_OUT.get(category, ()):
                    once_read(category, name, value, theirs)
            try:
                # Spare bits and the length of the FSPEC were not written down.
                theirs = {key: count for key, count in theirs.items() if "~" not in key}
                ours = {key: count for key, count in counts_of_line(line).items() if "~" not in key and key != "FSPEC/"}
                tally.compare(block, theirs, ours)
            except (Wrong, KeyError, ValueError) as error:
                tally.disagree(block, f"{type(error).__name__}: {error}")
    if expected and once:
        tally.disagree(b"", f"records at {sorted(once)[:5]} … are missing")
    return tally


# --- Command line ----------------------------------------------------------------------------------------------------------------------

BATCH = 2000


def do(task):
    what, *arguments = task
    return task, {"read": read, "write": write, "damage": damage}[what](*arguments)


def tell(results):
    """Prints the tables; whether all agree."""
    print(f"{'':<8} {'cat':>3} {'records':>9} {'items':>9} {'values':>11} {'kinds of values':>15}  disagreements")
    for (what, category), tally in results.items():
        numbers = tally.numbers
        kinds = {INDEX.sub("/*", path) for path in tally.paths} & set(KINDS[category])
        print(f"{what:<8} {category:>3} {numbers['records']:>9,} {numbers['items']:>9,} {numbers['values']:>11,} "
              f"{f'{len(kinds)} of {len(KINDS[category])}':>15}  {len(tally.disagreements) or 'none'}")
    for (what, category), tally in results.items():
        if tally.numbers["blocks"]:
            numbers = tally.numbers
            print(f"\ndamaged blocks of CAT{category:03}: {numbers['blocks']:,}, read by both {numbers['read by both']:,}, "
                  f"refused by both {numbers['refused by both']:,}, by one {numbers['differently']:,}")
            for kind, times in sorted(numbers.items()):
                if kind.startswith(("limit: ", "unexplained: ")):
                    print(f"  {times:>6,} {kind}")
            print()
            for limit, meaning in LIMITS.items():
                if any(limit in kind for kind in numbers if kind.startswith("limit: ")):
                    print(f"  {limit}: {meaning}")
    wrong = [(key, line) for key, tally in results.items() for line in tally.disagreements]
    for (what, category), line in wrong[:20]:
        print(f"{what} {category}: {line}", file=sys.stderr)
    if len(wrong) > 20:
        print(f"and {len(wrong) - 20:,} more", file=sys.stderr)
    return not wrong


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--binary", default=RELEASE, metavar="PROGRAM", help="the built utm-fusion")
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--count", type=int, default=2000, help="records of each category in each direction")
    arguments.add_argument("--mutations", type=int, default=100_000, help="damaged blocks of CAT048; of the others a fifth")
    arguments.add_argument("--jobs", type=int, default=2, help="processes")
    arguments.add_argument("--edition", default="2.7", choices=["2.1", "2.7"], help="of CAT021")
    arguments.add_argument("--capture", metavar="FILE", help="compare this recording instead")
    arguments.add_argument("--expected", metavar="NDJSON_GZ", help="what libasterix once read there")
    given = arguments.parse_args()
    began = time.monotonic()
    results = collections.defaultdict(Tally)
    if given.capture:
        with open(given.capture, "rb") as file:
            categories = {block[0] for _, block in split(file.read())} & set(RECORDS)
        for category in sorted(categories):
            results["capture", category] = capture(given.binary, given.capture, given.expected, category)
    else:
        tasks = []
        categories = (21,) if EDITION == "2.1" else (48, 21, 62, 63, 34, 65, 15)
        for category in categories:
            tasks += [("read", given.binary, category, given.seed, given.count), ("write", given.binary, category, given.seed, given.count)]
        mutations = {category: given.mutations // (1 if category == 48 else 5) for category in categories if EDITION != "2.1"}
        for category, count in mutations.items():
            tasks += [("damage", given.binary, category, f"{given.seed} {at}", min(BATCH, count - at)) for at in range(0, count, BATCH)]
        with multiprocessing.Pool(given.jobs) as pool:
            for (what, _, category, *_), tally in pool.imap(do, tasks):
                results[what, category].add(tally)
    agree = tell(results)
    print(f"\n{'the same in everything' if agree else 'NOT the same'}, {time.monotonic() - began:.0f} s")
    sys.exit(not agree)


if __name__ == "__main__":
    main()
