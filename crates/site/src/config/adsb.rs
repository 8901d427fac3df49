//! A sensor of kind `"adsb"`: a receiver of CAT021.

use asterix::cat021::Edition;

use super::sensors::Transponder;
use tables::kinds::{Kind, parsed};
use tables::reader::Section;
use tables::section;
use tables::table::{ByHand, Entry, Row, Table};
use tables::tree::quoted;

section! {
    /// Keys of a sensor with `kind = "adsb"`: those of a transponder, and the edition of CAT021.
    AdsB {
    } by hand {
        /// Edition of CAT021 that the receiver sends.
        edition: Edition = Edition::default();
        /// Keys shared with other receivers.
        receiver: Transponder = Transponder::default();
    }
}

/// Kind of the key `edition`. Written by hand because the type and its way of reading values belong to other crates.
fn edition() -> Kind<Edition> {
    parsed("`\"2.1\"` to `\"2.7\"`", str::parse)
}

impl ByHand for AdsB {
    fn more(&mut self, section: &mut Section<'_>) {
        if let Some(edition) = section.item("edition").and_then(|item| (edition().read)(&item)) {
            self.edition = edition;
        }
        self.receiver = Transponder::read_keys(section);
    }

    fn arrange(&self, entries: &mut Vec<Entry>) {
        entries.push(Entry::new("edition", quoted(&self.edition.to_string())));
        entries.extend(self.receiver.entries());
    }

    fn explain(rows: &mut Vec<Row>) {
        let about = "Edition of CAT021 that it follows; `utm-fusion info` names the one that a capture fits.";
        let usual = format!("`{}`", quoted(&Edition::default().to_string()));
        rows.push(Row::by_hand("edition", Some(&usual), &edition().values, about));
        rows.extend(Transponder::rows());
    }
}
