//! A hand-written parser of CAT048 that works on a slice: a reference for the speed of the typed decoder and for what it accepts.
//!
//! Edition 1.32, all 28 items. Values are raw counts; items of variable length are slices of the input. Nothing is allocated. It
//! shares no code with the crate and is strict: anything without a defined length is refused.

#![allow(dead_code, unreachable_pub, missing_docs, reason = "the fields are named as in the specification")]

/// Error without a reason, which a benchmark does not need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Malformed;

/// Maximum length of the FSPEC, in octets.
const FSPEC_MAX: usize = 8;
/// Maximum length of an extended item, in octets.
const CHAIN_MAX: usize = 16;

/// The items of a record, in their order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Record<'a> {
    pub i010: Option<Source>,
    /// 1/128 s.
    pub i140: Option<u32>,
    pub i020: Option<&'a [u8]>,
    pub i040: Option<Polar>,
    pub i070: Option<Code>,
    pub i090: Option<Level>,
    pub i130: Option<Plot>,
    pub i220: Option<u32>,
    /// Eight characters of 6 bits.
    pub i240: Option<u64>,
    /// The registers, 8 octets each, without their count.
    pub i250: Option<&'a [u8]>,
    pub i161: Option<u16>,
    pub i042: Option<Cartesian>,
    pub i200: Option<Velocity>,
    pub i170: Option<&'a [u8]>,
    pub i210: Option<Quality>,
    pub i030: Option<&'a [u8]>,
    pub i080: Option<u16>,
    pub i100: Option<ModeC>,
    /// 25 ft.
    pub i110: Option<i16>,
    pub i120: Option<Doppler<'a>>,
    pub i230: Option<u16>,
    pub i260: Option<&'a [u8; 7]>,
    pub i055: Option<Code>,
    pub i050: Option<Code>,
    pub i065: Option<u8>,
    pub i060: Option<u16>,
    /// With its length octet, like `re`.
    pub sp: Option<&'a [u8]>,
    pub re: Option<&'a [u8]>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source {
    pub sac: u8,
    pub sic: u8,
}

/// 1/256 NM, 360/65536 degrees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Polar {
    pub rho: u16,
    pub theta: u16,
}

/// Mode 1, 2 or 3/A.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Code {
    pub v: bool,
    pub g: bool,
    pub l: bool,
    pub code: u16,
}

/// 1/4 flight level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level {
    pub v: bool,
    pub g: bool,
    pub fl: i16,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Plot {
    pub srl: Option<u8>,
    pub srr: Option<u8>,
    pub sam: Option<i8>,
    pub prl: Option<u8>,
    pub pam: Option<i8>,
    pub rpd: Option<i8>,
    pub apd: Option<i8>,
}

/// 1/128 NM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cartesian {
    pub x: i16,
    pub y: i16,
}

/// 2^-14 NM/s, 360/65536 degrees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Velocity {
    pub gsp: u16,
    pub hdg: u16,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quality {
    pub sigx: u8,
    pub sigy: u8,
    pub sigv: u8,
    pub sigh: u8,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModeC {
    pub v: bool,
    pub g: bool,
    pub code: u16,
    pub confidence: u16,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Doppler<'a> {
    /// Flag D, and the speed in 1 m/s.
    pub cal: Option<(bool, i16)>,
    /// Three words each, without their count.
    pub rds: Option<&'a [u8]>,
}

impl<'a> Record<'a> {
    /// Parses the record at the start of `octets`, which extend to the end of the block. Returns it with its length.
    pub fn parse(octets: &'a [u8]) -> Result<(Self, usize), Malformed> {
        let mut rest = octets;
        let fspec = fspec(&mut rest)?;
        let has = |frn: u32| fspec & (1 << (28 - frn)) != 0;
        let mut record = Self::default();
        if has(1) {
            let [sac, sic] = fixed(&mut rest)?;
            record.i010 = Some(Source { sac, sic });
        }
        if has(2) {
            record.i140 = Some(word24(&mut rest)?);
        }
        if has(3) {
            record.i020 = Some(chain(&mut rest, CHAIN_MAX)?);
        }
        if has(4) {
            record.i040 = Some(Polar { rho: word(&mut rest)?, theta: word(&mut rest)? });
        }
        if has(5) {
            record.i070 = Some(code(word(&mut rest)?));
        }
        if has(6) {
            let word = word(&mut rest)?;
            record.i090 = Some(Level { v: word & 0x8000 != 0, g: word & 0x4000 != 0, fl: signed(word, 14) });
        }
        if has(7) {
            record.i130 = Some(plot(&mut rest)?);
        }
        if has(8) {
            record.i220 = Some(word24(&mut rest)?);
        }
        if has(9) {
            let [a, b, c, d, e, f] = fixed(&mut rest)?;
            record.i240 = Some(u64::from_be_bytes([0, 0, a, b, c, d, e, f]));
        }
        if has(10) {
            record.i250 = Some(repetitive(&mut rest, 8)?);
        }
        if has(11) {
            record.i161 = Some(word(&mut rest)? & 0x0fff);
        }
        if has(12) {
            record.i042 = Some(Cartesian { x: word(&mut rest)? as i16, y: word(&mut rest)? as i16 });
        }
        if has(13) {
            record.i200 = Some(Velocity { gsp: word(&mut rest)?, hdg: word(&mut rest)? });
        }
        if has(14) {
            record.i170 = Some(chain(&mut rest, CHAIN_MAX)?);
        }
        if has(15) {
            let [sigx, sigy, sigv, sigh] = fixed(&mut rest)?;
            record.i210 = Some(Quality { sigx, sigy, sigv, sigh });
        }
        if has(16) {
            record.i030 = Some(chain(&mut rest, usize::MAX)?);
        }
        if has(17) {
            record.i080 = Some(word(&mut rest)? & 0x0fff);
        }
        if has(18) {
            let (word, confidence) = (word(&mut rest)?, word(&mut rest)? & 0x0fff);
            let (v, g) = (word & 0x8000 != 0, word & 0x4000 != 0);
            record.i100 = Some(ModeC { v, g, code: word & 0x0fff, confidence });
        }
        if has(19) {
            record.i110 = Some(signed(word(&mut rest)?, 14));
        }
        if has(20) {
            record.i120 = Some(doppler(&mut rest)?);
        }
        if has(21) {
            record.i230 = Some(word(&mut rest)?);
        }
        if has(22) {
            let (item, after) = rest.split_first_chunk().ok_or(Malformed)?;
            record.i260 = Some(item);
            rest = after;
        }
        if has(23) {
            let octet = octet(&mut rest)?;
            record.i055 = Some(Code { code: u16::from(octet & 0x1f), ..code(u16::from(octet) << 8) });
        }
        if has(24) {
            record.i050 = Some(code(word(&mut rest)?));
        }
        if has(25) {
            record.i065 = Some(octet(&mut rest)? & 0x1f);
        }
        if has(26) {
            record.i060 = Some(word(&mut rest)? & 0x0fff);
        }
        if has(27) {
            record.sp = Some(explicit(&mut rest)?);
        }
        if has(28) {
            record.re = Some(explicit(&mut rest)?);
        }
        Ok((record, octets.len() - rest.len()))
    }
}

/// The 28 bits of an FSPEC without its FX bits, FRN 1 in the highest bit.
fn fspec(rest: &mut &[u8]) -> Result<u32, Malformed> {
    let mut bits = 0;
    for index in 0..FSPEC_MAX {
        let octet = octet(rest)?;
        let items = u32::from(octet >> 1);
        match index {
            0..4 => bits |= items << (21 - 7 * index),
            _ if items != 0 => return Err(Malformed),
            _ => {}
        }
        if octet & 1 == 0 {
            return Ok(bits);
        }
    }
    Err(Malformed)
}

/// Removes `length` octets from the start and returns them.
fn take<'a>(rest: &mut &'a [u8], length: usize) -> Result<&'a [u8], Malformed> {
    let (item, after) = rest.split_at_checked(length).ok_or(Malformed)?;
    *rest = after;
    Ok(item)
}

fn fixed<const N: usize>(rest: &mut &[u8]) -> Result<[u8; N], Malformed> {
    let (item, after) = rest.split_first_chunk().ok_or(Malformed)?;
    *rest = after;
    Ok(*item)
}

fn octet(rest: &mut &[u8]) -> Result<u8, Malformed> {
    fixed(rest).map(u8::from_be_bytes)
}

fn word(rest: &mut &[u8]) -> Result<u16, Malformed> {
    fixed(rest).map(u16::from_be_bytes)
}

fn word24(rest: &mut &[u8]) -> Result<u32, Malformed> {
    fixed(rest).map(|[a, b, c]| u32::from_be_bytes([0, a, b, c]))
}

/// The lowest `bits` of a word as two's complement.
fn signed(word: u16, bits: u32) -> i16 {
    (word << (16 - bits)) as i16 >> (16 - bits)
}

fn code(word: u16) -> Code {
    Code { v: word & 0x8000 != 0, g: word & 0x4000 != 0, l: word & 0x2000 != 0, code: word & 0x0fff }
}

fn chain<'a>(rest: &mut &'a [u8], most: usize) -> Result<&'a [u8], Malformed> {
    let last = rest.iter().take(most).position(|octet| octet & 1 == 0).ok_or(Malformed)?;
    take(rest, last + 1)
}

fn repetitive<'a>(rest: &mut &'a [u8], size: usize) -> Result<&'a [u8], Malformed> {
    let count = octet(rest)?;
    take(rest, usize::from(count) * size)
}

/// Removes an SP or RE field, whose length octet counts itself.
fn explicit<'a>(rest: &mut &'a [u8]) -> Result<&'a [u8], Malformed> {
    match *rest.first().ok_or(Malformed)? {
        0 => Err(Malformed),
        length => take(rest, usize::from(length)),
    }
}

fn plot(rest: &mut &[u8]) -> Result<Plot, Malformed> {
    let primary = octet(rest)?;
    if primary & 1 != 0 {
        return Err(Malformed);
    }
    let mut subfield = |bit: u8| if primary & bit != 0 { octet(rest).map(Some) } else { Ok(None) };
    Ok(Plot {
        srl: subfield(0x80)?,
        srr: subfield(0x40)?,
        sam: subfield(0x20)?.map(|octet| octet as i8),
        prl: subfield(0x10)?,
        pam: subfield(0x08)?.map(|octet| octet as i8),
        rpd: subfield(0x04)?.map(|octet| octet as i8),
        apd: subfield(0x02)?.map(|octet| octet as i8),
    })
}

fn doppler<'a>(rest: &mut &'a [u8]) -> Result<Doppler<'a>, Malformed> {
    let primary = octet(rest)?;
    if primary & 0x3f != 0 {
        return Err(Malformed);
    }
    let mut doppler = Doppler::default();
    if primary & 0x80 != 0 {
        let word = word(rest)?;
        doppler.cal = Some((word & 0x8000 != 0, signed(word, 10)));
    }
    if primary & 0x40 != 0 {
        doppler.rds = Some(repetitive(rest, 6)?);
    }
    Ok(doppler)
}
