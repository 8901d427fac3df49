//! A server of map tiles, with another origin than the service.

use std::io::{BufRead, BufReader, Write};
use std::net::TcpListener;
use std::sync::{Arc, Mutex, PoisonError};

/// Every tile has this colour, which is not used elsewhere on the map.
const TILE: &str = "<svg xmlns='http://www.w3.org/2000/svg' width='256' height='256'><rect width='256' height='256' fill='#f0f'/></svg>";

pub struct Tiles {
    url: String,
    asked: Arc<Mutex<Vec<String>>>,
}

impl Tiles {
    pub fn start() -> Self {
        let listener = TcpListener::bind(("127.0.0.1", 0)).unwrap();
        let url = format!("http://{}/", listener.local_addr().unwrap());
        let asked = Arc::<Mutex<Vec<String>>>::default();
        let heard = asked.clone();
        std::thread::spawn(move || {
            for mut connection in listener.incoming().flatten() {
                let mut request = String::new();
                let mut lines = BufReader::new(connection.try_clone().unwrap());
                // Browsers open connections in advance, and may close them unused.
                if lines.read_line(&mut request).unwrap_or(0) == 0 {
                    continue;
                }
                let path = request.split(' ').nth(1).unwrap_or_default().to_owned();
                heard.lock().unwrap_or_else(PoisonError::into_inner).push(path);
                let length = TILE.len();
                let head = format!(
                    "HTTP/1.1 200 OK\r\ncontent-type: image/svg+xml\r\ncontent-length: {length}\r\nconnection: close\r\n\r\n"
                );
                drop(connection.write_all((head + TILE).as_bytes()));
            }
        });
        Self { url, asked }
    }

    /// URL of the server; ends in a slash.
    pub fn url(&self) -> &str {
        &self.url
    }

    pub fn template(&self) -> String {
        format!("{}{{z}}/{{x}}/{{y}}.svg", self.url)
    }

    /// Paths of the requested tiles.
    pub fn asked(&self) -> Vec<String> {
        self.asked.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}
