//! Receives the packets of a port. A separate thread receives them, so that none is lost while earlier packets are
//! processed.

use std::io;
use std::net::{SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use mocap::{Code, Diagnostic, Error};

use crate::Failure;
use crate::args::ListenAddress;

/// The size of the longest UDP packet in bytes.
pub const LONGEST: usize = 65_536;

/// The most bytes of waiting packets: 50 seconds of a sender with 60 poses per second.
pub const MOST_WAITING: usize = 16 << 20;

/// The memory of a packet in bytes, besides its contents.
pub const OF_PACKET: usize = 64;

/// The time to wait for a packet before checking whether to end.
pub(super) const PATIENCE: Duration = Duration::from_millis(50);

/// A packet, and its time in seconds since the beginning.
pub struct Packet {
    pub bytes: Vec<u8>,
    pub seconds: f64,
}

/// The received packets, until listening has ended and no packet waits.
pub struct Packets {
    address: SocketAddr,
    heard: Receiver<Packet>,
    pub shared: Arc<Shared>,
}

#[derive(Default)]
pub struct Shared {
    pub waiting: AtomicUsize,
    lost: AtomicU64,
}

impl Packets {
    /// Listens until `is_over` is set, or for this number of seconds.
    pub fn of(source: ListenAddress, is_over: Arc<AtomicBool>, seconds: Option<f64>) -> Result<Self, Failure> {
        let socket = UdpSocket::bind(source.0).map_err(|error| of_socket(source.0, &error))?;
        socket.set_read_timeout(Some(PATIENCE))?;
        let (sender, heard) = channel();
        let shared = Arc::<Shared>::default();
        let packets = Self {
            // For port 0 the system chooses a port.
            address: socket.local_addr()?,
            heard,
            shared: Arc::clone(&shared),
        };
        let listen = move || hear(&socket, &sender, &shared, &is_over, seconds);
        thread::Builder::new().spawn(listen)?;
        Ok(packets)
    }

    /// The address on which it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The number of packets that were dropped, because too many waited.
    pub fn lost(&self) -> u64 {
        self.shared.lost.load(Ordering::Relaxed)
    }
}

impl Iterator for &Packets {
    type Item = Packet;

    fn next(&mut self) -> Option<Packet> {
        let packet = self.heard.recv().ok()?;
        let taken = packet.bytes.len() + OF_PACKET;
        self.shared.waiting.fetch_sub(taken, Ordering::Relaxed);
        Some(packet)
    }
}

fn hear(socket: &UdpSocket, sender: &Sender<Packet>, shared: &Shared, is_over: &AtomicBool, seconds: Option<f64>) {
    let mut buffer = vec![0; LONGEST];
    let begin = Instant::now();
    let is_late = || seconds.is_some_and(|seconds| begin.elapsed().as_secs_f64() >= seconds);
    while !is_over.load(Ordering::Relaxed) && !is_late() {
        // A failed receive, for example because a peer has gone, does not end the loop.
        let Ok((length, _)) = socket.recv_from(&mut buffer) else {
            continue;
        };
        let taken = length + OF_PACKET;
        if shared.waiting.fetch_add(taken, Ordering::Relaxed) > MOST_WAITING {
            shared.waiting.fetch_sub(taken, Ordering::Relaxed);
            shared.lost.fetch_add(1, Ordering::Relaxed);
            continue;
        }
        let packet = Packet {
            bytes: buffer[..length].to_vec(),
            seconds: begin.elapsed().as_secs_f64(),
        };
        // Nobody receives the packets any more.
        if sender.send(packet).is_err() {
            return;
        }
    }
}

pub(super) fn of_socket(address: SocketAddr, error: &io::Error) -> Error {
    let diagnostic = Diagnostic::new(Code::Io, format!("{address}: {error}"));
    Error::from(diagnostic.help("choose an address of this machine and a port that no other program has"))
}
