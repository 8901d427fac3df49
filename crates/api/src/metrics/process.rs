//! `process_…`: resources of the process, from Linux's `/proc`, with the names of Prometheus client libraries. Unavailable values
//! are left out.

use super::text::Metrics;

/// `sysconf(_SC_CLK_TCK)`: 100 on every system that Rust supports.
const TICKS_PER_S: f64 = 100.0;

/// Text of all metrics; empty without `/proc`.
pub(super) fn text() -> String {
    let read = |path| String::from_utf8_lossy(&std::fs::read(path).unwrap_or_default()).into_owned();
    let files = std::fs::read_dir("/proc/self/fd").ok();
    Process::of(&read("/proc/self/stat"), &read("/proc/self/status"), &read("/proc/stat"))
        // The directory listing itself is an open file.
        .text(files.map(|files| files.count().saturating_sub(1)), open_files(&read("/proc/self/limits")))
}

/// Limit of open files, from the system's table of limits; `None` means no limit.
pub(crate) fn open_files(limits: &str) -> Option<usize> {
    let line = limits.lines().find_map(|line| line.strip_prefix("Max open files"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// Values from `/proc` (proc(5)).
#[derive(Debug, Default, PartialEq)]
struct Process {
    cpu_s: Option<f64>,
    threads: Option<u64>,
    /// Start in seconds since 1970; `None` if `/proc` shows only processes.
    started_s: Option<f64>,
    resident_octets: Option<u64>,
    virtual_octets: Option<u64>,
}

impl Process {
    /// Parses `/proc/self/stat`, `/proc/self/status` and `/proc/stat`.
    fn of(stat: &str, status: &str, system: &str) -> Self {
        // The name in parentheses may contain any character. Fields count from 1; the third follows the name.
        let fields: Vec<&str> =
            stat.rsplit_once(')').map_or_else(Vec::new, |(_, rest)| rest.split_whitespace().collect());
        let field = |number: usize| fields.get(number - 3)?.parse::<u64>().ok();
        let ticks = |ticks: u64| ticks as f64 / TICKS_PER_S;
        let of = |text: &str, name: &str| -> Option<u64> {
            let line = text.lines().find_map(|line| line.strip_prefix(name))?;
            line.split_whitespace().next()?.parse().ok()
        };
        let boot_s = of(system, "btime ");
        Self {
            cpu_s: field(14).zip(field(15)).map(|(user, kernel)| ticks(user + kernel)),
            threads: field(20),
            started_s: boot_s.zip(field(22)).map(|(boot_s, after)| boot_s as f64 + ticks(after)),
            resident_octets: of(status, "VmRSS:").map(|kibibytes| kibibytes * 1024),
            virtual_octets: field(23),
        }
    }

    fn text(&self, open_files: Option<usize>, most_files: Option<usize>) -> String {
        let mut out = Metrics::new("process_");
        out.known("cpu_seconds_total", "Processor time, of the program and for it", self.cpu_s);
        out.known("resident_memory_bytes", "Memory that is in use", self.resident_octets);
        out.known("virtual_memory_bytes", "Addresses that are in use", self.virtual_octets);
        out.known("threads", "Threads", self.threads);
        out.known("open_fds", "Open files and sockets", open_files);
        out.known("max_fds", "How many may be open", most_files);
        out.known("start_time_seconds", "When the process started, seconds since 1970", self.started_s);
        out.into_text()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn process_with_any_name_is_parsed() {
        let stat = "4711 (a) b (c)) S 1 4711 4711 0 -1 4194560 917 0 2 0 250 50 7 8 20 0 9 0 12345 104857600 2560 0\n";
        let status = "Name:\ta) b (c)\nVmPeak:\t  200000 kB\nVmRSS:\t   10240 kB\n";
        let read = Process::of(stat, status, "cpu 1 2 3\nbtime 1700000000\nprocesses 5\n");
        let expected = Process {
            cpu_s: Some(3.0),
            threads: Some(9),
            started_s: Some(1_700_000_123.45),
            resident_octets: Some(10_485_760),
            virtual_octets: Some(104_857_600),
        };
        assert_eq!(read, expected);
        assert_eq!(Process::of("", "", ""), Process::default());
        assert_eq!(Process::default().text(None, None), "");
        let text = expected.text(Some(12), Some(1024));
        assert!(
            text.contains("# TYPE process_cpu_seconds_total counter\nprocess_cpu_seconds_total 3\n"),
            "{text}"
        );
        assert!(text.contains("\nprocess_open_fds 12\n"), "{text}");
        // A kernel that hides everything but processes.
        assert_eq!(Process::of(stat, status, "").started_s, None);
    }

    #[test]
    fn the_limit_of_open_files_is_the_soft_one() {
        let table = "Limit                     Soft Limit           Hard Limit           Units     \n\
                     Max processes             63450                63450                processes \n\
                     Max open files            1024                 524288               files     \n";
        assert_eq!(open_files(table), Some(1024));
        assert_eq!(
            open_files("Max open files            unlimited            unlimited            files"),
            None
        );
        assert_eq!(open_files(""), None);
    }
}
