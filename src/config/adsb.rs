//! A sensor of kind `"adsb"`: a receiver of CAT021.

use asterix::cat021::Edition;

use super::sensors::Transponder;
use tables::kinds::{Kind, parsed};
use tables::reader::Section;
use tables::section;
use tables::table::{ByHand, Entry, Row, Table};
use tables::tree::quoted;

section! {
    /// The keys of a sensor with `kind = "adsb"`: those of a transponder, and its edition.
    AdsB {
    } by hand {
        /// Edition of CAT021 that it follows.
        edition: Edition = Edition::default();
        /// What it has in common with other receivers.
        receiver: Transponder = Transponder::default();
    }
}

/// Read by hand: neither the edition nor the way in which values are written is of this crate.
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
