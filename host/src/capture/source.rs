//! Where telemetry comes from.

use super::CaptureError;
use std::io::Read;
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// A TCP line on which nothing comes for this long has ended.
const SILENCE: Duration = Duration::from_secs(10);
/// Between two attempts to connect.
const PAUSE: Duration = Duration::from_millis(50);

/// Opens `tcp:HOST:PORT`, or a file, pipe or serial device by its path (set a device's speed with `stty` first).
/// A connection that is refused is tried again for `wait`: the controller may still be starting.
///
/// # Errors
/// [`CaptureError::Connect`] or [`CaptureError::Open`].
pub fn open(source: &str, wait: Duration) -> Result<Box<dyn Read>, CaptureError> {
    let Some(address) = source.strip_prefix("tcp:") else {
        return match std::fs::File::open(source) {
            Ok(file) => Ok(Box::new(file)),
            Err(error) => Err(CaptureError::Open {
                path: source.to_owned(),
                error,
            }),
        };
    };
    let start = Instant::now();
    let connected = loop {
        match TcpStream::connect(address) {
            Err(error)
                if error.kind() == std::io::ErrorKind::ConnectionRefused
                    && start.elapsed() < wait =>
            {
                std::thread::sleep(PAUSE);
            }
            connected => break connected,
        }
    };
    connected
        .and_then(|stream| {
            stream.set_read_timeout(Some(SILENCE))?;
            Ok(Box::new(stream) as Box<dyn Read>)
        })
        .map_err(|error| CaptureError::Connect {
            address: address.to_owned(),
            error,
        })
}
