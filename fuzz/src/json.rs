//! Any octets, taken for a datagram that is decoded to lines and encoded again, and for lines.

use asterix::{Record, blocks, cat034, cat048, cat065, cat129};
use utm_fusion::json::{Encoder, Place, write_record};

/// Every record that can be read comes back from its line, octet by octet; and no line, whatever it holds, does harm.
pub fn exercise(data: &[u8]) {
    there_and_back::<cat034::Record>(data);
    there_and_back::<cat048::Record>(data);
    there_and_back::<cat065::Record>(data);
    there_and_back::<cat129::Record>(data);
    let (mut encoder, mut out) = (Encoder::default(), Vec::new());
    for line in String::from_utf8_lossy(data).lines() {
        let before = out.len();
        let taken = encoder.line(line, &mut out);
        assert!(out.len() >= before && (taken.is_ok() || !taken.unwrap_err().to_string().is_empty()));
    }
    encoder.finish(&mut out);
}

fn there_and_back<R: Record>(data: &[u8]) {
    // Behind the header of a block, whatever that says.
    let contents = data.get(3..).unwrap_or_default();
    let whole = blocks(data).flatten().filter(|block| block.category == R::CATEGORY);
    for contents in whole.map(|block| block.contents()).chain([contents]) {
        let mut rest = contents;
        while let Ok((record, length)) = R::decode(rest) {
            let (octets, after) = rest.split_at(length);
            rest = after;
            let mut line = Vec::new();
            let place = Place { input: None, offset: 3, block: 0 };
            write_record(&mut line, &record, octets, place, None, false);
            let line = String::from_utf8(line).expect("a line is a text");
            let (mut encoder, mut again) = (Encoder::default(), Vec::new());
            if length + 3 <= usize::from(u16::MAX) {
                encoder.line(&line, &mut again).expect("what was printed can be encoded");
                encoder.finish(&mut again);
                assert_eq!((again[0], &again[3..]), (R::CATEGORY, octets), "{line}");
            }
        }
    }
}
