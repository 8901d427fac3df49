//! `[output]` and `[state]`.

use std::path::PathBuf;

use super::network::read_sink;
use super::reader::{Item, Section, each};
use super::types::{Output, Record, SerialSource, State};

pub(super) fn read_output(mut section: Section<'_>) -> Option<Output> {
    let asterix = each(section.item("asterix"), read_sink);
    let serial = section
        .item("serial")
        .and_then(|i| i.word(&[("uas", SerialSource::Uas), ("track-number", SerialSource::TrackNumber)]));
    let status = section.item("status").and_then(|item| item.flag());
    let flush_on_stop = section.item("flush_on_stop").and_then(|item| item.flag());
    let record = section.item("record").and_then(|item| read_record(item.section()?));
    section.finish();
    Some(Output {
        asterix: asterix?,
        serial: serial.unwrap_or(SerialSource::Uas),
        status: status.unwrap_or(true),
        flush_on_stop: flush_on_stop.unwrap_or(true),
        record,
    })
}

fn read_record(mut section: Section<'_>) -> Option<Record> {
    let dir = read_dir(section.need("dir", "dir = …, the directory of the recordings"));
    let rotate_mib = section
        .item("rotate_mib")
        .and_then(|i| i.whole(1..=1_048_576u32, "a file grows to a whole number of MiB, 1 to 1048576"));
    let keep = section
        .item("keep")
        .and_then(|i| i.whole(1..=1_000_000u32, "the files kept are a whole number, 1 to 1000000"));
    section.finish();
    Some(Record { dir: dir?, rotate_mib: rotate_mib.unwrap_or(256), keep: keep.unwrap_or(16) })
}

pub(super) fn read_state(mut section: Section<'_>) -> Option<State> {
    let dir = section.item("dir").map(|item| read_dir(Some(item)));
    let hours = section.item("history_hours").map(|item| {
        item.number("the history goes back 0 (none) to 8784 hours", |hours| (0.0..=8784.0).contains(&hours))
    });
    let mib = section
        .item("history_mib")
        .map(|item| item.whole(1..=1_048_576u32, "the history takes a whole number of MiB, 1 to 1048576"));
    section.finish();
    Some(State {
        dir: dir.unwrap_or(Some(PathBuf::from("state")))?,
        history_hours: hours.unwrap_or(Some(24.0))?,
        history_mib: mib.unwrap_or(Some(512))?,
    })
}

fn read_dir(item: Option<Item<'_>>) -> Option<PathBuf> {
    Some(item?.text()?.into())
}
