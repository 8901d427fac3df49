//! `[integrity]`.

use tables::kinds::{Kind, flag, named, number};
use tables::reader::Section;
use tables::section;
use tables::table::ByHand;
use tables::{names, written_by_name};

/// An index is a logarithm of a likelihood ratio; an honest transponder stays below a few tens.
fn index() -> Kind<f64> {
    number("an index is at least 0, and at most 1000", |index| (0.0..=1000.0).contains(&index))
}

section! {
    /// Whether transponders are what they say they are (docs/INTEGRITY.md). Not used by the `reference` profile.
    Integrity {
        /// What is done about a transponder that lies.
        action: Action = Action::Flag, named();
        /// Index (natural logarithm of how much likelier a lie is than none, by radar) above which an identity is suspect.
        on: f64 = 8.5, index();
        /// Index below which it is no longer; below `on`.
        off: f64 = 2.0, index();
        /// The offset that radar would not have shown by now is at most this, metres, where an identity is verified.
        alert_limit_m: f64 = 100.0,
            number("an alert limit is above 0, and at most 10000 metres", |metres| metres > 0.0 && metres <= 1e4);
        /// Whether the accuracy of a suspect or failed identity holds its estimated offset.
        accuracy: bool = true, flag();
        /// Whether the aircraft that a radar sees where a suspect is not is published as soon as it lasts 2 s.
        show_twin: bool = true, flag();
        /// Whether a suspect or failed identity counts for nothing in the registration, and in the association of others.
        protect: bool = true, flag();
    } by hand {}
}

names! {
    /// What is done about a transponder that lies.
    #[derive(Copy, Eq)]
    Action, "action" {
        /// Nothing is computed.
        Off = "off",
        /// It is flagged, and an alert raised.
        Flag = "flag",
        /// It is flagged, and published where it says it is, apart from what radar sees.
        Split = "split",
    }
}
written_by_name!(Action);

/// Keys that have to agree with each other.
impl ByHand for Integrity {
    fn more(&mut self, section: &mut Section<'_>) {
        if self.on <= self.off {
            section.contradict(
                &["on", "off"],
                "on is above off (by default 8.5 and 2), or a flag would come and go; raise on or lower off",
            );
        }
    }
}
