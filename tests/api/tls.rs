//! Clients that start a TLS handshake and do not complete it.

use std::time::Duration;

use rcgen::{CertificateParams, KeyPair};
use tokio::net::TcpStream;
use utm_fusion::api::Options;
use utm_fusion::config::TlsFiles;

use crate::common::{Site, receive, send};

#[tokio::test]
async fn stalled_tls_handshake_ends_and_is_counted() {
    let folder = std::env::temp_dir().join(format!("utm-fusion-tls-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let [certificate, key] = ["certificate.pem", "key.pem"].map(|name| folder.join(name));
    let pair = KeyPair::generate().unwrap();
    let own = CertificateParams::new(vec!["localhost".to_owned()]).unwrap().self_signed(&pair).unwrap();
    std::fs::write(&certificate, own.pem()).unwrap();
    std::fs::write(&key, pair.serialize_pem()).unwrap();
    let options = Options { header_timeout: Duration::from_secs(1), ..Options::default() };
    let site = Site::with(options, |config| config.http.tls = Some(TlsFiles { certificate, key }));
    std::fs::remove_dir_all(&folder).unwrap();
    let address = site.listen().await;
    let mut half_open = Vec::new();
    for index in 0..20 {
        let socket = TcpStream::connect(address).await.unwrap();
        if index % 2 == 0 {
            // Header of a record whose content is never sent.
            send(&socket, &[22, 3, 1, 2, 0]).await;
        }
        half_open.push(socket);
    }
    for socket in half_open {
        let ended = async { while receive(&socket, &mut [0; 1024]).await > 0 {} };
        tokio::time::timeout(Duration::from_secs(20), ended).await.expect("a half-open handshake stays");
    }
    let metrics = site.get("/metrics").await.text;
    assert!(metrics.contains("_refused_total{reason=\"tls\"} 20\n"), "{metrics}");
}
