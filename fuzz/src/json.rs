//! Random octets as a datagram, decoded to lines and encoded again, and as lines.

use asterix::cat021::Edition;
use asterix::{Record, blocks, cat015, cat021, cat034, cat048, cat062, cat063, cat065, cat129};
use utm_fusion::json::{Encoder, Entry, Named, Place, write_record};

/// Every readable record is restored from its line, octet by octet. No line causes a panic. Blocks encoded from lines with items
/// can be read.
pub fn exercise(data: &[u8]) {
    there_and_back::<cat015::Record>(data);
    there_and_back::<cat021::Record>(data);
    there_and_back::<cat034::Record>(data);
    there_and_back::<cat048::Record>(data);
    there_and_back::<cat062::Record>(data);
    there_and_back::<cat063::Record>(data);
    there_and_back::<cat065::Record>(data);
    there_and_back::<cat129::Record>(data);
    let (mut encoder, mut out) = (Encoder::default(), Vec::new());
    for line in String::from_utf8_lossy(data).lines() {
        let before = out.len();
        let taken = encoder.line(line, &mut out);
        assert!(out.len() >= before && (taken.is_ok() || !taken.unwrap_err().to_string().is_empty()));
    }
    encoder.finish(&mut out);
    String::from_utf8_lossy(data).lines().for_each(encoded_is_read);
}

fn encoded_is_read(line: &str) {
    let (mut encoder, mut out) = (Encoder::default(), Vec::new());
    // Octets given in hexadecimal may be invalid.
    let has_items = line.contains("\"items\":{") && !line.contains("\"hex\"");
    if has_items && encoder.line(line, &mut out).is_ok() {
        encoder.finish(&mut out);
        for block in blocks(&out) {
            let block = block.expect("a block is whole");
            let read = match block.category {
                21 => {
                    let edition = if line.contains("\"2.1\"") { Edition::V2_1 } else { Edition::default() };
                    block.records_in::<cat021::Record>(edition).all(|record| record.is_ok())
                }
                15 => block.records::<cat015::Record>().all(|record| record.is_ok()),
                34 => block.records::<cat034::Record>().all(|record| record.is_ok()),
                48 => block.records::<cat048::Record>().all(|record| record.is_ok()),
                62 => block.records::<cat062::Record>().all(|record| record.is_ok()),
                63 => block.records::<cat063::Record>().all(|record| record.is_ok()),
                65 => block.records::<cat065::Record>().all(|record| record.is_ok()),
                129 => block.records::<cat129::Record>().all(|record| record.is_ok()),
                category => unreachable!("category {category} has no items"),
            };
            assert!(read, "{line}");
        }
    }
}

fn there_and_back<R: Record<Edition: Default + Named>>(data: &[u8]) {
    // The contents of a block, whatever its header states.
    let contents = data.get(3..).unwrap_or_default();
    let whole = blocks(data).flatten().filter(|block| block.category == R::CATEGORY);
    for contents in whole.map(|block| block.contents()).chain([contents]) {
        let mut rest = contents;
        while let Ok((record, length)) = R::decode(rest, R::Edition::default()) {
            let (octets, after) = rest.split_at(length);
            rest = after;
            let mut line = Vec::new();
            let place = Place { input: None, offset: 3, block: 0 };
            let entry = Entry::typed(&record, R::Edition::default(), octets, place, None);
            write_record(&mut line, &entry, false);
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
