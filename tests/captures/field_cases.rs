//! Captures that caused problems in practice, from the folder that `UTM_FUSION_SHARED_DATA` names.

use std::path::{Path, PathBuf};

use remote_id::messages;
use utm_fusion::capture::{Capture, CapturedDatagram};
use utm_fusion::gateways::remote_id::{BroadcastLine, lines};

fn folder() -> Option<PathBuf> {
    let folder =
        std::env::var_os("UTM_FUSION_SHARED_DATA").map(|root| PathBuf::from(root).join("field-cases"));
    if folder.is_none() {
        println!("skipped: UTM_FUSION_SHARED_DATA is not set");
    }
    folder
}

fn datagrams(file: impl AsRef<Path>) -> Vec<CapturedDatagram> {
    Capture::open(file.as_ref())
        .expect("the field case is there")
        .map(|datagram| datagram.expect("it can be read"))
        .collect()
}

#[test]
fn mirrored_datagrams_are_all_read() {
    let Some(folder) = folder() else { return };
    for name in ["erspan1", "erspan2", "gre_ip", "gre_teb", "ipip", "llcsnap", "mpls", "pppoe"] {
        let read = datagrams(folder.join("20-mirror-encapsulations").join(name).with_extension("pcap"));
        assert_eq!(read.len(), 40, "{name}");
        for datagram in read {
            let endpoints = datagram.endpoints.unwrap();
            let ends = (endpoints.source.to_string(), endpoints.destination.to_string());
            assert_eq!(ends, ("10.48.0.10:50048".to_owned(), "239.192.48.1:8048".to_owned()));
            assert_eq!((datagram.payload.len(), datagram.payload[0]), (24, 48), "{name}");
        }
    }
}

/// Number of valid messages and of faults in all lines.
fn counts(read: &[CapturedDatagram]) -> (usize, usize) {
    let all = read.iter().flat_map(|datagram| lines(&datagram.payload));
    let all = all
        .flat_map(|line| messages(&BroadcastLine::parse(line).expect("a line").octets).collect::<Vec<_>>());
    let (sound, faults): (Vec<_>, Vec<_>) = all.partition(Result::is_ok);
    (sound.len(), faults.len())
}

#[test]
fn remote_id_frames_are_all_heard() {
    let Some(folder) = folder() else { return };
    for (name, heard, sound) in [
        ("14-dissector30-beacon-flags/plain", 21, 105),
        ("14-dissector30-beacon-flags/retry", 21, 105),
        ("14-dissector30-beacon-flags/pwr_more", 21, 105),
        ("14-dissector30-beacon-flags/order_htc", 21, 105),
        ("14-dissector30-beacon-flags/nan_plain", 42, 42),
        ("14-dissector30-beacon-flags/nan_retry", 42, 42),
        ("14-dissector30-beacon-flags/nan_order_htc", 42, 42),
        ("15-sniffle74-bt4-legacy/adv_ind", 25, 25),
        ("15-sniffle74-bt4-legacy/adv_nonconn", 25, 25),
        ("15-sniffle74-bt4-legacy/adv_scan_ind", 25, 25),
        ("15-sniffle74-bt4-legacy/scan_rsp", 25, 25),
        ("17-dissector15-linktype256/raw251", 50, 50),
        ("17-dissector15-linktype256/sniffle_ext", 20, 20),
        ("17-dissector15-linktype256/sniffle_legacy", 50, 50),
        ("18-dissector19-hci/btmon201", 50, 50),
    ] {
        let read = datagrams(folder.join(name).with_extension("pcap"));
        assert_eq!((read.len(), counts(&read)), (heard, (sound, 0)), "{name}");
    }
}

#[test]
fn packs_of_every_size_are_read_as_far_as_they_are_sound() {
    let Some(folder) = folder() else { return };
    for (name, sound, faults) in [("ten", 200, 0), ("cut", 40, 20), ("size24", 0, 5)] {
        let read = datagrams(folder.join("37-mavlink1701-pack-sizes").join(name).with_extension("pcap"));
        assert_eq!(counts(&read), (sound, faults), "{name}");
    }
}

#[test]
fn positions_of_receivers_with_ids_and_stamps_are_all_read() {
    let Some(folder) = folder() else { return };
    // Two alternating frames, 1.4 km apart. One alone is half a position. In `mixed` two are copies within half a second.
    for (name, positions, first, last) in [
        (
            "10-traffic213-radarcape-midnight/rc-20220622T235955Z.beast",
            19,
            "2022-06-22T23:59:55.500Z",
            "2022-06-23T00:00:04.500Z",
        ),
        (
            "11-readsb-e3/e3-20240916T120618Z.beast",
            11,
            "2024-09-16T12:06:18.500Z",
            "2024-09-16T12:06:23.500Z",
        ),
        (
            "11-readsb-e3/e4-20240916T120618Z.beast",
            11,
            "2024-09-16T12:06:18.500Z",
            "2024-09-16T12:06:23.500Z",
        ),
        (
            "11-readsb-e3/mixed-20240916T120618Z.beast",
            13,
            "2024-09-16T12:06:18.200Z",
            "2024-09-16T12:06:24.000Z",
        ),
        (
            "13-mlatclient12-avr/in-20160213T120000Z.avr",
            5,
            "2016-02-13T12:00:28.974Z",
            "2016-02-13T12:00:30.974Z",
        ),
    ] {
        let read = datagrams(folder.join(name));
        let time = |datagram: &CapturedDatagram| datagram.received.unwrap().to_string();
        let ends = read.first().zip(read.last()).map(|(first, last)| (time(first), time(last)));
        assert_eq!((read.len(), ends), (positions, Some((first.to_owned(), last.to_owned()))), "{name}");
    }
}
