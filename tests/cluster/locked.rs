//! Servers with `config/nats.conf` and certificates of `scripts/cluster-certificates`: permissions of each role, and errors of
//! refused connections.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Duration;

use async_nats::{Client, ConnectOptions, jetstream};
use futures_util::StreamExt;
use futures_util::future::join_all;
use utm_fusion::cluster::Log;
use utm_fusion::config::{Cluster, Role};

use crate::program::{Scratch, utm_fusion};
use crate::servers::{self, Lock, Servers};
use crate::site::{Setup, Site, proven, until};

/// Time after which a request counts as refused. A server does not answer a refused request.
const REFUSED: Duration = Duration::from_millis(700);

/// Locked servers of the region "trial"; `None` without nats-server or openssl.
fn locked(count: usize) -> Option<(Servers, Scratch)> {
    let binary = servers::binary()?;
    let scratch = Scratch::new();
    certificates(&scratch.path("certificates"))?;
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/nats.conf");
    let configuration =
        scratch.file("nats.conf", fs::read_to_string(shipped).unwrap().replace("demo", "trial"));
    let lock = Lock { configuration, certificates: scratch.path("certificates/server") };
    Some((Servers::start_locked(&binary, &scratch.path(""), count, lock), scratch))
}

fn certificates(directory: &Path) -> Option<()> {
    if Command::new("openssl").arg("version").output().is_err() {
        println!("skipped: no openssl");
        return None;
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/cluster-certificates");
    let made = Command::new(script).arg(directory).output().unwrap();
    assert!(made.status.success(), "{made:?}");
    Some(())
}

/// A member of the region.
fn member(servers: &Servers) -> Cluster {
    Cluster {
        servers: servers.urls(),
        node: "one".to_owned(),
        region: "trial".to_owned(),
        roles: vec![Role::Picture],
        replicas: 1,
        ..Cluster::default()
    }
}

/// A plain NATS client with the certificate of a role.
async fn client(servers: &Servers, certificates: &Path, role: &str) -> Client {
    let own = certificates.join(role);
    ConnectOptions::new()
        .add_root_certificates(own.join("ca.pem"))
        .add_client_certificate(own.join("certificate.pem"), own.join("key.pem"))
        .custom_inbox_prefix(format!("_INBOX.{role}"))
        .request_timeout(Some(REFUSED))
        .connect(servers.url(0))
        .await
        .unwrap()
}

const ROLES: [&str; 4] = ["gateway", "node", "picture", "operator"];

/// Subjects, and the roles that may publish to them.
const WRITES: [(&str, &[&str]); 13] = [
    ("utm.in.trial.25.2", &["gateway"]),
    ("utm.in.trial.to.whole", &["node", "picture"]),
    ("utm.out.trial.whole", &["node"]),
    ("$KV.UTM_OWN_trial.gateway.g0", &["gateway"]),
    ("$KV.UTM_OWN_trial.node.n0", &["node"]),
    ("$KV.UTM_OWN_trial.whole.owner", &["node"]),
    ("$KV.UTM_OWN_trial.whole.report", &["node"]),
    ("$KV.UTM_OWN_trial.drain.n0", &["operator"]),
    ("$KV.UTM_NUM_trial.gateway.g0", &["gateway", "operator"]),
    ("$KV.UTM_NUM_trial.config.0", &["gateway", "node", "picture"]),
    ("$KV.UTM_NUM_trial.b.0", &["node"]),
    ("$O.UTM_CK_trial.C.part", &["node"]),
    ("$O.UTM_CK_trial.M.whole", &["node"]),
];

/// Requests that no role may make.
const ASKED: [&str; 6] = [
    "$JS.API.STREAM.DELETE.UTM_OUT_trial",
    "$JS.API.STREAM.PURGE.UTM_OUT_trial",
    "$JS.API.STREAM.PURGE.KV_UTM_OWN_trial",
    "$JS.API.STREAM.UPDATE.UTM_OUT_trial",
    "$JS.API.STREAM.MSG.DELETE.UTM_IN_trial",
    "$JS.API.STREAM.CREATE.UTM_IN_another",
];

#[tokio::test(flavor = "multi_thread")]
async fn each_role_writes_only_its_own_subjects() {
    let Some((servers, scratch)) = locked(1) else { return };
    let directory = scratch.path("certificates");
    let log = Log::open(&proven(&member(&servers), Some(&directory), "node")).await.unwrap();
    assert!(log.is_connected());
    for role in ROLES {
        let client = client(&servers, &directory, role).await;
        let mut streams = jetstream::new(client.clone());
        streams.set_timeout(REFUSED);
        let written = WRITES.map(|(subject, _)| {
            let streams = &streams;
            async move {
                let sent = streams.publish(subject, "anything".into()).await.unwrap();
                sent.await.is_ok()
            }
        });
        for ((subject, may), is_written) in WRITES.into_iter().zip(join_all(written).await) {
            assert_eq!(is_written, may.contains(&role), "{role} writes {subject}\n{}", servers.log(0));
        }
        let asked = join_all(ASKED.map(|subject| client.request(subject, "{}".into()))).await;
        for (subject, answer) in ASKED.into_iter().zip(asked) {
            assert!(answer.is_err(), "{role} asks {subject}: {answer:?}");
        }
        let makes = client.request("$JS.API.CONSUMER.CREATE.UTM_IN_trial", "{}".into()).await;
        assert_eq!(makes.is_ok(), ["node", "operator"].contains(&role), "{role} reads inputs: {makes:?}");
    }
}

/// Servers send an answer to the subject that the request names, even if the requester may not publish to it.
#[tokio::test(flavor = "multi_thread")]
async fn server_answers_to_a_gateway_do_not_reach_the_log() {
    let Some((servers, scratch)) = locked(1) else { return };
    let directory = scratch.path("certificates");
    let log = Log::open(&proven(&member(&servers), Some(&directory), "node")).await.unwrap();
    let gateway = client(&servers, &directory, "gateway").await;
    let streams = jetstream::new(client(&servers, &directory, "node").await);
    let messages =
        async |stream: &str| streams.get_stream(stream).await.unwrap().cached_info().state.messages;
    for answer in ["utm.out.trial.whole", "$KV.UTM_OWN_trial.whole.owner", "utm.in.trial.to.whole"] {
        gateway.publish_with_reply("utm.in.trial.25.2", answer, "input".into()).await.unwrap();
        gateway.publish_with_reply("$JS.API.STREAM.INFO.UTM_IN_trial", answer, "".into()).await.unwrap();
    }
    gateway.flush().await.unwrap();
    until("the inputs", async || (messages("UTM_IN_trial").await == 3).then_some(())).await;
    tokio::time::sleep(REFUSED).await;
    assert_eq!(messages("UTM_IN_trial").await, 3, "the inputs alone");
    assert_eq!((messages("UTM_OUT_trial").await, messages("KV_UTM_OWN_trial").await), (0, 0));
    assert_eq!(log.last("whole").await.unwrap(), None);
}

#[tokio::test(flavor = "multi_thread")]
async fn roles_cannot_read_each_others_answers() {
    let Some((servers, scratch)) = locked(1) else { return };
    let directory = scratch.path("certificates");
    Log::open(&proven(&member(&servers), Some(&directory), "node")).await.unwrap();
    let node = client(&servers, &directory, "node").await;
    for role in ["gateway", "picture", "operator"] {
        let curious = client(&servers, &directory, role).await;
        let mut heard = Vec::new();
        for subject in ["_INBOX.node.>", ">", "utm.in.trial.>", "_INBOX.>"] {
            heard.push(curious.subscribe(subject).await.unwrap());
        }
        curious.flush().await.unwrap();
        node.request("$JS.API.STREAM.INFO.UTM_IN_trial", "".into()).await.unwrap();
        let heard = join_all(heard.iter_mut().map(|heard| tokio::time::timeout(REFUSED, heard.next()))).await;
        assert!(heard.iter().all(|heard| !matches!(heard, Ok(Some(_)))), "{role} hears {heard:?}");
    }
}

/// Runs all processes of a region, each with the certificate of its role.
#[tokio::test(flavor = "multi_thread")]
async fn locked_region_shows_its_picture_and_nothing_is_refused() {
    let Some((servers, scratch)) = locked(1) else { return };
    let certificates = Some(scratch.path("certificates"));
    let site = Site::over(servers, scratch, Setup { certificates, ..Setup::default() }).await;
    until("aircraft on the map", async || {
        let (status, tracks) = site.ask("/api/v1/tracks").await?;
        (status == 200 && tracks["features"].as_array().is_some_and(|tracks| tracks.len() >= 3)).then_some(())
    })
    .await;
    // Nodes take over with their permissions, and an operator's commands work with the operator's.
    let operator = operator(&site);
    let [owner, standby] = site.pair().await;
    let drained = asked(&operator, &["drain", owner]).await;
    assert!(drained.status.success(), "{drained:?}");
    assert_eq!(site.owner().await.unwrap().node, standby);
    site.pair().await;
    let verified = asked(&operator, &["verify", "--duration", "4s"]).await;
    let said = String::from_utf8_lossy(&verified.stdout).into_owned();
    assert!(said.contains(" 0 doubled, 0 missing, ") && said.contains("all the same"), "{verified:?}");
    let status = asked(&operator, &["status"]).await;
    assert!(String::from_utf8_lossy(&status.stdout).contains(standby), "{status:?}");
    let refused: Vec<String> =
        site.servers.log(0).lines().filter(|line| line.contains("Violation")).map(str::to_owned).collect();
    assert!(refused.is_empty(), "{}", refused.join("\n"));
    // A picture does not have an operator's permissions.
    let picture = asked(&site.file("p0"), &["drain", standby]).await;
    assert!(!picture.status.success(), "{picture:?}");
    let said = String::from_utf8_lossy(&picture.stderr).into_owned();
    assert!(said.contains("Permissions Violation for Publish to") && said.contains("drain."), "{said}");
}

/// Configuration file of an operator of the site.
fn operator(site: &Site) -> PathBuf {
    let text = fs::read_to_string(site.file("p0")).unwrap();
    let text = text.replace("/picture/", "/operator/").replace("_INBOX.picture", "_INBOX.operator");
    let inbox = if text.contains("inbox = ") { "" } else { "inbox = \"_INBOX.operator\"\n" };
    let file = site.file("operator");
    fs::write(&file, text.replace("[cluster]\n", &format!("[cluster]\n{inbox}"))).unwrap();
    file
}

/// Runs `utm-fusion cluster` with these arguments and that file.
async fn asked(file: &Path, arguments: &[&str]) -> Output {
    let mut command = utm_fusion("cluster");
    command.args(arguments).arg("--config").arg(file);
    tokio::task::spawn_blocking(move || command.output().unwrap()).await.unwrap()
}

/// A site's configuration file with these credentials.
fn site_file(scratch: &Scratch, servers: &[String], proofs: &str) -> PathBuf {
    scratch.file(
        "site.toml",
        format!(
            "[site]\nname = \"trial\"\nsac = 25\nsic = 1\nlatitude_deg = 51.0\nlongitude_deg = 4.0\nheight_amsl_m = 0\n\
             [[sensors]]\nid = \"air\"\nkind = \"transponder\"\nsac = 0\nsic = 0\n\
             inputs = [{{ address = \"127.0.0.1\", port = 18999 }}]\n\
             [state]\ndir = {:?}\n[cluster]\nservers = {servers:?}\nnode = \"one\"\nregion = \"trial\"\nroles = [\"picture\"]\n{proofs}\n",
            scratch.path("state")
        ),
    )
}

#[tokio::test(flavor = "multi_thread")]
async fn refused_credentials_are_an_error_with_the_cause() {
    let Some((servers, scratch)) = locked(1) else { return };
    let Some(()) = certificates(&scratch.path("others")) else { return };
    let path = |of: &str| scratch.path(of).display().to_string();
    let (own, others) = (path("certificates"), path("others"));
    let proofs = |ca: &str, of: &str| {
        format!("ca = \"{ca}/server/ca.pem\"\ncertificate = \"{of}/certificate.pem\"\nkey = \"{of}/key.pem\"")
    };
    let keys = ["certificates/picture", "certificates/server", "others/picture"].map(|of| {
        let text = fs::read_to_string(scratch.path(of).join("key.pem")).unwrap();
        text.lines().nth(1).unwrap().to_owned()
    });
    for (proofs, cause) in [
        // No certificate, then one whose issuer the servers do not trust.
        (format!("ca = \"{own}/server/ca.pem\""), "wants one: cluster.certificate and cluster.key"),
        (proofs(&own, &format!("{others}/picture")), "does not take the certificate of this process"),
        // A server whose certificate the configured authority has not issued.
        (proofs(&others, &format!("{own}/picture")), "is not issued by one of cluster.ca"),
        // A certificate of no role.
        (proofs(&own, &format!("{own}/server")), "knows no user of this certificate"),
    ] {
        let file = site_file(&scratch, &servers.urls(), &proofs);
        let told = asked(&file, &["status"]).await;
        let said = String::from_utf8_lossy(&told.stderr).into_owned();
        assert!(!told.status.success() && said.contains(cause), "{proofs}\n{said}");
        assert!(keys.iter().all(|key| !said.contains(key)), "{said}");
        let mut command = utm_fusion("check");
        let checked = command.arg("--network").arg(&file).output().unwrap();
        let said = String::from_utf8_lossy(&checked.stdout).into_owned();
        assert!(!checked.status.success() && said.contains(cause), "{said}");
    }
    let file = site_file(&scratch, &servers.urls(), &proofs(&own, &format!("{own}/picture")));
    let checked = utm_fusion("check").arg("--network").arg(&file).output().unwrap();
    let said = String::from_utf8_lossy(&checked.stdout).into_owned();
    assert!(said.contains(&format!("log     {}: ok", servers.url(0))), "{said}");
}

#[test]
fn invalid_credentials_file_is_named_without_its_content() {
    let scratch = Scratch::new();
    if certificates(&scratch.path("certificates")).is_none() {
        return;
    }
    let own = |file: &str| scratch.path("certificates").join(file).display().to_string();
    let secret = "SUAHUSHUSHUSHUSHUSH";
    let (odd, missing) = (scratch.file("odd", secret), scratch.path("missing"));
    let (odd, missing) = (odd.display().to_string(), missing.display().to_string());
    let pair = |certificate: &str, key: &str| format!("certificate = \"{certificate}\"\nkey = \"{key}\"");
    let [of_node, of_gateway] = ["node/certificate.pem", "gateway/key.pem"].map(own);
    for (proofs, cause) in [
        (format!("ca = \"{missing}\""), "cannot be read"),
        (format!("ca = \"{odd}\""), "holds no certificate"),
        (format!("ca = \"{}\"", own("node/key.pem")), "holds no certificate"),
        (pair(&of_node, &missing), "missing: cannot be read"),
        (pair(&of_node, &odd), "odd: cannot be read as a private key"),
        (pair(&of_node, &of_gateway), "cannot be used with"),
        (format!("credentials = \"{missing}\""), "missing: cannot be read"),
        (format!("credentials = \"{odd}\""), "odd: cannot parse user JWT"),
        (format!("nkey = \"{odd}\""), "odd: holds no seed"),
    ] {
        let file = site_file(&scratch, &["tls://127.0.0.1:1".to_owned()], &proofs);
        for command in ["check", "run"] {
            let told = utm_fusion(command).arg("--config").arg(&file).output().unwrap();
            let said = String::from_utf8_lossy(&told.stderr).into_owned();
            assert!(!told.status.success() && said.contains(cause), "{command} {proofs}\n{said}");
            assert!(!said.contains(secret), "{said}");
        }
    }
    let file = site_file(&scratch, &["nats://192.0.2.1:4222".to_owned()], "");
    let warned = utm_fusion("check").arg(&file).output().unwrap();
    assert!(
        String::from_utf8_lossy(&warned.stderr).contains("neither encrypted nor authenticated"),
        "{warned:?}"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn nkey_file_is_accepted() {
    let Some(binary) = servers::binary() else { return };
    let scratch = Scratch::new();
    let Some([seed, user]) = nkey(&scratch) else { return };
    let configuration = format!("jetstream {{}}\nauthorization {{ users: [{{ nkey: {user} }}] }}\n");
    let lock =
        Lock { configuration: scratch.file("nats.conf", configuration), certificates: scratch.path("") };
    let servers = Servers::start_locked(&binary, &scratch.path(""), 1, lock);
    let cluster = Cluster { nkey: Some(scratch.file("seed.nk", &seed)), ..member(&servers) };
    assert!(Log::open(&cluster).await.unwrap().is_connected());
    let file = site_file(&scratch, &servers.urls(), "");
    let told = asked(&file, &["status"]).await;
    let said = String::from_utf8_lossy(&told.stderr).into_owned();
    assert!(said.contains("authorization violation") && !said.contains(&seed), "{said}");
}

/// A seed and its public key in the format of NATS for Ed25519 keys: prefix, key and CRC, in base 32.
fn nkey(scratch: &Scratch) -> Option<[String; 2]> {
    let openssl = |arguments: &[&str]| Command::new("openssl").args(arguments).output();
    let file = scratch.path("key.pem").display().to_string();
    if openssl(&["genpkey", "-algorithm", "ed25519", "-out", &file]).is_err() {
        println!("skipped: no openssl");
        return None;
    }
    let last_32 = |arguments: &[&str]| {
        let octets = openssl(arguments).unwrap().stdout;
        octets[octets.len() - 32..].to_vec()
    };
    let private = last_32(&["pkey", "-in", &file, "-outform", "DER"]);
    let public = last_32(&["pkey", "-in", &file, "-pubout", "-outform", "DER"]);
    const SEED: u8 = 18 << 3;
    const USER: u8 = 20 << 3;
    Some([
        written([&[SEED | USER >> 5, (USER & 31) << 3], &private[..]].concat()),
        written([&[USER], &public[..]].concat()),
    ])
}

fn written(mut octets: Vec<u8>) -> String {
    let crc = octets.iter().fold(0_u16, |crc, octet| {
        (0..8)
            .fold(crc ^ u16::from(*octet) << 8, |crc, _| crc << 1 ^ if crc & 0x8000 > 0 { 0x1021 } else { 0 })
    });
    octets.extend(crc.to_le_bytes());
    let bits: String = octets.iter().map(|octet| format!("{octet:08b}")).collect();
    let of = |five: &[u8]| {
        let text = format!("{:0<5}", String::from_utf8_lossy(five));
        char::from(b"ABCDEFGHIJKLMNOPQRSTUVWXYZ234567"[usize::from_str_radix(&text, 2).unwrap()])
    };
    bits.as_bytes().chunks(5).map(of).collect()
}
