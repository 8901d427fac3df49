//! TLS with the certificate and key of `[http] tls`, read at the start and on SIGHUP.

use std::fmt;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::{self, PemObject};
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::{Error, InconsistentKeys, ServerConfig};

use super::error::StartError;
use super::validity::Validity;
use fusion::time::{SECOND, Time};
use site::config::TlsFiles;

/// Remaining validity below which a warning is given: the certificate should have been renewed.
const SOON_NS: i64 = 14 * 24 * 3600 * SECOND;

/// A certificate in use.
#[derive(Clone)]
pub struct Tls {
    acceptor: TlsAcceptor,
    /// Path of the certificate.
    certificate: String,
    /// Validity; `None` if it could not be read, which clients will report.
    validity: Option<Validity>,
}

impl fmt::Debug for Tls {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Tls").field("certificate", &self.certificate).finish_non_exhaustive()
    }
}

impl Tls {
    /// Reads both files.
    ///
    /// # Errors
    /// A file cannot be used; the error states the remedy.
    pub fn load(files: &TlsFiles) -> Result<Self, StartError> {
        let chain = certificates(&files.certificate)?;
        let validity = chain.first().and_then(|own| Validity::of(own));
        let key = key(&files.key)?;
        let refuse = |file: &Path, problem: String| Err(StartError::Tls { file: file.to_owned(), problem });
        // TLS 1.2 and 1.3, with the defaults of rustls.
        let config = ServerConfig::builder_with_provider(Arc::new(ring::default_provider()))
            .with_safe_default_protocol_versions()
            .and_then(|builder| builder.with_no_client_auth().with_single_cert(chain, key));
        let mut config = match config {
            Ok(config) => config,
            Err(Error::InconsistentKeys(InconsistentKeys::KeyMismatch)) => {
                let problem = format!(
                    "this key does not belong to the first certificate in {}; the chain begins with the \
                     service's own certificate",
                    files.certificate.display()
                );
                return refuse(&files.key, problem);
            }
            Err(Error::InvalidCertificate(error)) => {
                return refuse(&files.certificate, format!("the certificate cannot be used: {error:?}"));
            }
            Err(error) => {
                let problem = format!(
                    "the key cannot be used: {error}; RSA from 2048 bits, ECDSA P-256 or P-384 and Ed25519 can"
                );
                return refuse(&files.key, problem);
            }
        };
        config.alpn_protocols = vec![b"http/1.1".to_vec()];
        let certificate = files.certificate.display().to_string();
        Ok(Self { acceptor: Arc::new(config).into(), certificate, validity })
    }

    /// Acceptor of TLS connections.
    pub fn acceptor(&self) -> TlsAcceptor {
        self.acceptor.clone()
    }

    /// Expiry of the certificate.
    pub fn expires(&self) -> Option<Time> {
        self.validity.map(|validity| validity.until)
    }

    /// Warning about the dates of the certificate, if clients reject it now or soon.
    pub fn warning(&self, now: Time) -> Option<String> {
        let Validity { from, until } = self.validity?;
        let (file, renew) = (&self.certificate, "renew it and send SIGHUP");
        if now >= until {
            Some(format!("{file}: the certificate expired at {until}: clients refuse it; {renew}"))
        } else if now < from {
            Some(format!(
                "{file}: the certificate is good only from {from} on; is this machine's clock right?"
            ))
        } else if until.nanos() - now.nanos() < SOON_NS {
            Some(format!("{file}: the certificate expires at {until}; {renew}"))
        } else {
            None
        }
    }
}

fn certificates(file: &Path) -> Result<Vec<CertificateDer<'static>>, StartError> {
    let text = read(file, "certificate")?;
    let refuse = |problem: String| StartError::Tls { file: file.to_owned(), problem };
    let chain: Result<Vec<_>, pem::Error> = CertificateDer::pem_slice_iter(&text).collect();
    let chain = chain.map_err(|error| refuse(format!("this is not whole PEM text: {error}")))?;
    if !chain.is_empty() {
        return Ok(chain);
    }
    Err(refuse(if holds(&text, "PRIVATE KEY") {
        "holds a key and no certificate; are certificate and key exchanged?".to_owned()
    } else {
        "holds no certificate; it has to be PEM: -----BEGIN CERTIFICATE-----, the service's own first, then those \
         that issued it"
            .to_owned()
    }))
}

fn key(file: &Path) -> Result<PrivateKeyDer<'static>, StartError> {
    let text = read(file, "key")?;
    let problem = match PrivateKeyDer::from_pem_slice(&text) {
        Ok(key) => return Ok(key),
        Err(_) if holds(&text, "BEGIN ENCRYPTED PRIVATE KEY") || holds(&text, "Proc-Type: 4,ENCRYPTED") => {
            "the key is encrypted, and nobody is there to give the password; openssl pkey -in … -out … decrypts it"
                .to_owned()
        }
        Err(pem::Error::NoItemsFound) if holds(&text, "BEGIN CERTIFICATE") => {
            "holds a certificate and no key; are certificate and key exchanged?".to_owned()
        }
        Err(pem::Error::NoItemsFound) => {
            "holds no private key; it has to be PEM: -----BEGIN PRIVATE KEY-----".to_owned()
        }
        Err(error) => format!("this is not whole PEM text: {error}"),
    };
    Err(StartError::Tls { file: file.to_owned(), problem })
}

fn read(file: &Path, what: &str) -> Result<Vec<u8>, StartError> {
    fs::read(file).map_err(|error| {
        let problem =
            format!("the {what} cannot be read: {error}; the service's user needs the right to read it");
        StartError::Tls { file: file.to_owned(), problem }
    })
}

fn holds(text: &[u8], part: &str) -> bool {
    text.windows(part.len()).any(|window| window == part.as_bytes())
}
