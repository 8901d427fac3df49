//! Connections to receivers: TCP, with TLS where it is wanted.

use std::fmt;
use std::io;
use std::path::Path;
use std::sync::Arc;

use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, RootCertStore};

/// Either kind of connection.
pub(crate) trait Stream: AsyncRead + AsyncWrite + Send + Unpin {}

impl<S: AsyncRead + AsyncWrite + Send + Unpin> Stream for S {}

/// Where a receiver is.
#[derive(Clone)]
pub(crate) struct Dial {
    host: String,
    port: u16,
    tls: Option<(TlsConnector, ServerName<'static>)>,
}

impl fmt::Debug for Dial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Dial").field("host", &self.host).field("port", &self.port).finish_non_exhaustive()
    }
}

impl Dial {
    /// Without TLS.
    pub(crate) fn plain(host: &str, port: u16) -> Self {
        Self { host: host.trim_matches(['[', ']']).to_owned(), port, tls: None }
    }

    /// With TLS; `ca`: the certificates that the receiver's has to be issued by, else those that this machine trusts.
    pub(crate) fn tls(host: &str, port: u16, ca: Option<&Path>) -> Result<Self, String> {
        let plain = Self::plain(host, port);
        let roots = match ca {
            Some(file) => from_file(file)?,
            None => trusted()?,
        };
        let config = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
            .with_safe_default_protocol_versions()
            .map_err(|error| error.to_string())?
            .with_root_certificates(roots)
            .with_no_client_auth();
        let name = ServerName::try_from(plain.host.clone())
            .map_err(|_| format!("{} is no name that a certificate can have", plain.host))?;
        Ok(Self { tls: Some((Arc::new(config).into(), name)), ..plain })
    }

    /// Connects.
    pub(crate) async fn dial(&self) -> io::Result<Box<dyn Stream>> {
        let stream = TcpStream::connect((&*self.host, self.port)).await?;
        stream.set_nodelay(true)?;
        Ok(match &self.tls {
            None => Box::new(stream),
            Some((connector, name)) => Box::new(connector.connect(name.clone(), stream).await?),
        })
    }
}

fn from_file(file: &Path) -> Result<RootCertStore, String> {
    let certificates: Vec<_> = CertificateDer::pem_file_iter(file)
        .and_then(Iterator::collect)
        .map_err(|error| format!("{}: cannot be read as certificates in PEM: {error}", file.display()))?;
    let mut roots = RootCertStore::empty();
    for certificate in certificates {
        let added = roots.add(certificate);
        added.map_err(|error| format!("{}: a certificate cannot be used: {error}", file.display()))?;
    }
    if roots.is_empty() {
        return Err(format!("{}: holds no certificate", file.display()));
    }
    Ok(roots)
}

/// Those of the system, or of the variable `SSL_CERT_FILE`.
fn trusted() -> Result<RootCertStore, String> {
    const NONE: &str = "this machine trusts no certificates that are known; install them (Debian: ca-certificates), or name \
                        those of the receiver with ca = …";
    let file = openssl_probe::probe().cert_file.ok_or(NONE)?;
    let certificates = CertificateDer::pem_file_iter(&file)
        .map_err(|error| format!("{}: cannot be read: {error}", file.display()))?;
    let mut roots = RootCertStore::empty();
    // Some of the system's are too old for it.
    let (added, _) = roots.add_parsable_certificates(certificates.flatten());
    if added == 0 { Err(NONE.to_owned()) } else { Ok(roots) }
}
