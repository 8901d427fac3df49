//! The guarantee of a recording: its replay equals the data sent.

use std::path::{Path, PathBuf};

use fusion::time::Time;
use utm_fusion::config::Config;

use crate::common::{complete_from, files, read, replayed_datagrams};

/// Input files with their output files, in order of time; checks that all can be read to their end.
pub(crate) fn pairs(directory: &Path) -> Vec<(PathBuf, PathBuf)> {
    let (inputs, outputs) = (files(directory, "input-", ".pcap"), files(directory, "output-", ".pcap"));
    assert_eq!(inputs.len(), outputs.len(), "{inputs:?}, {outputs:?}");
    for file in inputs.iter().chain(&outputs) {
        assert!(read(file).1, "{} is damaged", file.display());
    }
    inputs.into_iter().zip(outputs).collect()
}

/// Checks that the replay of the input equals the output, from the slot in its head until the last reception in the file,
/// or in the last file to its end. Returns the number of datagrams.
pub(crate) fn is_exact(config: &Config, (input, output): &(PathBuf, PathBuf), is_last: bool) -> usize {
    let from = complete_from(input) + config.fusion.latency();
    let until = read(input).0.last().map_or(from, |datagram| datagram.received.unwrap());
    let promised = |due: Time| due >= from && (is_last || due <= until);
    let pick =
        |all: Vec<(Time, Vec<u8>)>| -> Vec<_> { all.into_iter().filter(|(due, _)| promised(*due)).collect() };
    let sent = pick(crate::common::datagrams(output));
    let again = pick(replayed_datagrams(input));
    // After a full disk, datagrams may be missing at the end of a file.
    let whole = if is_last { again.len() } else { sent.len().min(again.len()) };
    assert!(
        sent.len() + 8 > again.len(),
        "{}: {} sent, {} replayed",
        input.display(),
        sent.len(),
        again.len()
    );
    assert!(sent == again[..whole], "{}: {} sent, {} replayed", input.display(), sent.len(), again.len());
    sent.len()
}
