//! Features of the log that the cluster relies on: expected sequences, keys created once, leases that expire, duplicates dropped.

use std::time::{Duration, Instant};

use async_nats::jetstream;
use async_nats::jetstream::context::PublishErrorKind;
use async_nats::jetstream::kv::{CreateErrorKind, Operation, Store, UpdateErrorKind};
use async_nats::jetstream::object_store;
use async_nats::jetstream::stream::{Config, DiscardPolicy, StorageType};

use crate::{append, cluster, in_memory};

const EXPECTED: &str = "Nats-Expected-Last-Subject-Sequence";

#[tokio::test(flavor = "multi_thread")]
async fn log_satisfies_the_cluster_contract() {
    let Some((servers, _scratch)) = cluster(3).await else { return };
    let streams = jetstream::new(servers.client().await);
    streams.create_stream(in_memory("OUT", "out")).await.unwrap();
    // Run concurrently: these tests mostly wait.
    tokio::join!(
        an_append_needs_the_subjects_last_sequence(&streams),
        a_double_is_dropped_within_its_window(&streams),
        a_lease_is_made_once_renewed_given_up_and_goes(&streams),
        an_object_comes_back(&streams),
    );
}

/// The last sequence is the subject's, whatever else is in the stream.
async fn an_append_needs_the_subjects_last_sequence(streams: &jetstream::Context) {
    let first = append(streams, "out.a", (EXPECTED, "0")).await.unwrap().sequence;
    append(streams, "out.b", (EXPECTED, "0")).await.unwrap();
    let second = append(streams, "out.a", (EXPECTED, &first.to_string())).await.unwrap().sequence;
    assert!(second > first);
    for stale in [0, first, second + 1] {
        let refused = append(streams, "out.a", (EXPECTED, &stale.to_string())).await.unwrap_err();
        assert_eq!(refused.kind(), PublishErrorKind::WrongLastSequence, "{stale}: {refused}");
    }
    let last =
        streams.get_stream("OUT").await.unwrap().get_last_raw_message_by_subject("out.a").await.unwrap();
    assert_eq!(last.sequence, second);
    assert!(append(streams, "out.a", (EXPECTED, &second.to_string())).await.is_ok());
}

async fn a_double_is_dropped_within_its_window(streams: &jetstream::Context) {
    let append = async |number| append(streams, "out.double", ("Nats-Msg-Id", number)).await.unwrap();
    let first = append("1").await;
    assert!(!first.duplicate);
    let again = append("1").await;
    assert!(again.duplicate && again.sequence == first.sequence, "{again:?}");
    assert!(!append("2").await.duplicate);
    // The stream's window is 2 s; servers remove older identifiers only at intervals.
    tokio::time::sleep(Duration::from_secs(5)).await;
    assert!(!append("1").await.duplicate);
}

async fn a_lease_is_made_once_renewed_given_up_and_goes(streams: &jetstream::Context) {
    let lease = Duration::from_secs(3);
    let leases = bucket(streams, "OWN", lease).await;
    let mine = leases.create("a.owner", "one".into()).await.unwrap();
    let refused = leases.create("a.owner", "two".into()).await.unwrap_err();
    assert_eq!(refused.kind(), CreateErrorKind::AlreadyExists);

    let mine = leases.update("a.owner", "one".into(), mine).await.unwrap();
    let refused = leases.update("a.owner", "two".into(), mine - 1).await.unwrap_err();
    assert_eq!(refused.kind(), UpdateErrorKind::WrongLastRevision);
    leases.delete_expect_revision("a.owner", Some(mine)).await.unwrap();
    assert_eq!(leases.get("a.owner").await.unwrap(), None);

    // The lease is free after it was given up, and after its renewals stopped.
    let theirs = leases.create("a.owner", "two".into()).await.unwrap();
    let began = Instant::now();
    assert!(theirs > mine, "the revision is the epoch");
    while leases.create("a.owner", "one".into()).await.is_err() {
        assert!(began.elapsed() < lease * 3, "the lease does not go");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    println!("a lease of {lease:?} was free {:?} after its last renewal", began.elapsed());
    assert!(began.elapsed() >= lease - Duration::from_millis(100), "{:?}", began.elapsed());
    let entry = leases.entry("a.owner").await.unwrap().unwrap();
    assert!(entry.revision > theirs && entry.operation == Operation::Put, "{entry:?}");
}

async fn an_object_comes_back(streams: &jetstream::Context) {
    let objects = streams
        .create_object_store(object_store::Config {
            bucket: "CK".to_owned(),
            storage: StorageType::File,
            num_replicas: 3,
            ..object_store::Config::default()
        })
        .await
        .unwrap();
    let checkpoint: Vec<u8> = (0..1_000_000_u32).flat_map(|number| (number % 251).to_be_bytes()).collect();
    objects.put("a", &mut checkpoint.as_slice()).await.unwrap();
    let mut back = Vec::new();
    // The leader has the object at once; the server that answers may have it a moment later.
    let stream = streams.get_stream("OBJ_CK").await.unwrap();
    stream.get_last_raw_message_by_subject("$O.CK.M.YQ==").await.unwrap();
    let began = Instant::now();
    let mut object = loop {
        match objects.get("a").await {
            Ok(object) => break object,
            Err(error) => assert!(began.elapsed() < Duration::from_secs(5), "{error}"),
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    };
    tokio::io::AsyncReadExt::read_to_end(&mut object, &mut back).await.unwrap();
    assert!(back == checkpoint);
}

/// A bucket in memory on three servers whose entries expire after `age`. It is created as a stream for two reasons. The client's
/// own way asks for the account first, and cannot read the answer of nats-server 2.9. It also lets every server answer reads,
/// which may lack the last acknowledged entry.
async fn bucket(streams: &jetstream::Context, name: &str, age: Duration) -> Store {
    let config = Config {
        name: format!("KV_{name}"),
        subjects: vec![format!("$KV.{name}.>")],
        max_messages_per_subject: 1,
        max_age: age,
        duplicate_window: age,
        storage: StorageType::Memory,
        num_replicas: 3,
        discard: DiscardPolicy::New,
        allow_rollup: true,
        deny_delete: true,
        allow_direct: false,
        ..Config::default()
    };
    streams.create_stream(config).await.unwrap();
    let bucket = streams.get_key_value(name).await.unwrap();
    assert!(!bucket.stream.cached_info().config.allow_direct, "the leader alone answers");
    bucket
}
