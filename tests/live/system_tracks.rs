//! `run` with destinations for CAT062: the data that they receive, beside CAT129 and instead of it.

use std::collections::BTreeSet;
use std::fs;
use std::net::Ipv4Addr;
use std::sync::atomic::Ordering;
use std::time::Duration;

use asterix::cat063::Connection;
use asterix::{Record, blocks, cat062, cat063};
use utm_fusion::config::{Address, Category, PictureKind, Sink};

use crate::common::{datagrams, group, joined, only, replayed, replayed_as_cat062};
use crate::senders::json;
use crate::stage::Stage;

const SCENARIO: &str =
    "name = \"live\"\nduration_s = 22\n[drones]\nmultirotors = 2\nequipped = 2\n[birds]\ncount = 3\n";

fn records<R: Record<Edition = ()>>(datagrams: &[Vec<u8>]) -> Vec<R> {
    let blocks = datagrams.iter().flat_map(|datagram| blocks(datagram).map(Result::unwrap));
    let blocks = blocks.filter(|block| block.category == R::CATEGORY);
    blocks.flat_map(|block| block.records::<R>().map(|located| located.unwrap().record)).collect()
}

#[test]
fn cat062_destinations_get_tracks_and_sensor_status() {
    let stage = Stage::new(SCENARIO, 22_500, |config, _| {
        let usual = config.output.asterix[0];
        for (last, picture) in [(98, PictureKind::Lagged), (97, PictureKind::Now)] {
            let address = Address::Multicast { group: group(last), interface: Ipv4Addr::LOCALHOST };
            let port = usual.port + 100 - u16::from(last);
            config.output.asterix.push(Sink { address, port, picture, category: Category::Cat062, ..usual });
        }
        config.output.status = true;
    });
    let port = |index: usize| stage.config.output.asterix[index].port;
    let (stop, usual) = stage.listen();
    let all = |index: usize, last| stage.listen_for(group(last), port(index), &stop, |_| true);
    let (lagged, now) = (all(1, 98), all(2, 97));
    let service = stage.run("run.log");
    stage.send(0.0, 9.0);
    // The service's own tracks and sensors come back to it, from another sender.
    let own: BTreeSet<u8> = [62, 63].into();
    let (sender, mut echoed) = (stage.sender(), BTreeSet::new());
    let echo = joined(group(98), port(1), Ipv4Addr::LOCALHOST);
    while echoed != own {
        let mut octets = [0; 65536];
        let length = echo.recv(&mut octets).unwrap();
        if own.contains(&octets[0]) {
            sender.send_to(&octets[..length], stage.to(1)).unwrap();
            echoed.insert(octets[0]);
        }
    }
    stage.send(9.0, 17.0);
    std::thread::sleep(Duration::from_millis(1500));
    let unknown = json(([127, 0, 0, 1], service.http_port()).into(), "/api/v1/sensors")["unknown"].take();
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    stop.store(true, Ordering::Relaxed);
    let [usual, lagged, now] = [usual, lagged, now].map(|heard| heard.join().unwrap());

    let refused: BTreeSet<u64> =
        unknown.as_array().unwrap().iter().map(|source| source["category"].as_u64().unwrap()).collect();
    assert_eq!(refused, [62, 63].into(), "{unknown}");
    assert!(unknown.as_array().unwrap().iter().all(|source| source["own"] == true), "{unknown}");

    // The recording has only CAT129, and replays to the data that each destination received.
    let directory = stage.scratch.path("recordings");
    let (input, output) = (only(&directory, "input-", ".pcap"), only(&directory, "output-", ".pcap"));
    let sent: Vec<Vec<u8>> = datagrams(&output).into_iter().map(|(_, payload)| payload).collect();
    assert!(usual.len() > 20 && usual == sent, "{} heard, {} recorded", usual.len(), sent.len());
    assert!(fs::read(&output).unwrap() == replayed(&input));
    for (picture, heard) in [("lagged", &lagged), ("now", &now)] {
        let file = stage.scratch.file("cat062.pcap", replayed_as_cat062(picture, &input));
        let tracks = |category: u8| heard.iter().filter(move |datagram| datagram[0] == category);
        let payloads: Vec<Vec<u8>> = datagrams(&file).into_iter().map(|(_, payload)| payload).collect();
        assert!(payloads.iter().eq(tracks(62)), "{picture}: {} of {}", tracks(62).count(), payloads.len());
        assert!(payloads.len() > 20 && tracks(65).count() > 10 && tracks(129).count() == 0);

        // Each second has the status of each sensor: at first without receptions, then operational.
        let service = if picture == "lagged" { 1 } else { 2 };
        let sensors = records::<cat063::Record>(heard);
        let said = |record: &cat063::Record| {
            (record.sensor.map(|sensor| sensor.sic), record.service_identification.unwrap().number())
        };
        let expected: Vec<_> =
            stage.config.sensors.iter().map(|sensor| (Some(sensor.sic), service)).collect();
        assert!(sensors.len() > 10 * expected.len());
        for second in sensors.chunks(expected.len()) {
            assert_eq!(second.iter().map(said).collect::<Vec<_>>(), expected);
        }
        let states: Vec<Connection> =
            sensors.iter().map(|record| record.status.unwrap().connection()).collect();
        assert_eq!(states[0], Connection::NotConnected);
        assert!(states.contains(&Connection::Operational), "{states:?}");
        let times: Vec<u32> =
            sensors.chunks(expected.len()).map(|second| second[0].time_of_day.unwrap().count()).collect();
        assert!(times.windows(2).all(|pair| pair[1] > pair[0]), "{times:?}");

        let tracks = records::<cat062::Record>(heard);
        assert!(tracks.iter().all(|track| track.service_identification.unwrap().number() == service));
        assert!(tracks.iter().filter(|track| track.target_identification.is_some()).count() > 20);
    }
}
