//! Whether a timed job has its machine to itself.

use std::fs::{File, TryLockError};
use std::io;
use std::path::Path;
use std::time::{Duration, Instant};

/// The file that timed jobs of this machine lock, in the folder for temporary files. One for all adapters: two jobs that
/// choose the best adapter get the same one, and jobs on two adapters still share the processor that submits their work.
const FILE: &str = "raystep-timed.lock";

/// Other programs may use this much of a processor core on average: what an idle desktop does, and far less than a
/// second job.
const MOST_CORES: f64 = 0.5;

/// The claim on a machine, held while a timed job runs.
pub(super) struct Owner {
    lock: Option<File>,
    before: Option<Ticks>,
}

impl Owner {
    /// Waits for the machine.
    pub(super) fn wait(patience: Duration) -> Self {
        let lock = open(&std::env::temp_dir().join(FILE)).ok().and_then(|file| lock(file, patience));
        Self { lock, before: Ticks::now() }
    }

    /// The lock, for the child process: if this process is killed, the machine is taken until the child has ended.
    pub(super) fn handle(&self) -> Option<File> {
        self.lock.as_ref().and_then(|file| file.try_clone().ok())
    }

    /// Whether anything else ran at the same time.
    pub(super) fn was_shared(&self) -> bool {
        let others = self.before.as_ref().zip(Ticks::now()).and_then(|(before, after)| before.others(&after));
        self.lock.is_none() || others.is_some_and(|cores| cores > MOST_CORES)
    }
}

/// Opens the file, which another user may have created: in a folder for all users, Linux lets nobody else create it again.
fn open(path: &Path) -> io::Result<File> {
    File::open(path).or_else(|_| create(path)).or_else(|_| File::open(path))
}

/// Creates the file so that other users can open it, whatever the umask.
fn create(path: &Path) -> io::Result<File> {
    let file = File::create_new(path)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        file.set_permissions(std::fs::Permissions::from_mode(0o644))?;
    }
    Ok(file)
}

fn lock(file: File, patience: Duration) -> Option<File> {
    const PAUSE: Duration = Duration::from_millis(100);
    let begin = Instant::now();
    loop {
        match file.try_lock() {
            Ok(()) => return Some(file),
            Err(TryLockError::WouldBlock) if begin.elapsed() < patience => std::thread::sleep(PAUSE),
            Err(_) => return None,
        }
    }
}

/// Processor time since the machine started, in ticks.
#[derive(Debug, PartialEq)]
struct Ticks {
    /// Of all programs.
    busy: f64,
    /// Of this program and its children that have ended.
    own: f64,
    /// Elapsed.
    elapsed: f64,
}

impl Ticks {
    /// As Linux tells it; elsewhere, unknown.
    fn now() -> Option<Self> {
        let read = |path| std::fs::read_to_string(path).ok();
        Self::of(&read("/proc/stat")?, &read("/proc/self/stat")?)
    }

    fn of(machine: &str, own: &str) -> Option<Self> {
        let line = machine.lines().next()?.strip_prefix("cpu ")?;
        // user, nice, system, idle, iowait, irq, softirq, steal
        let times: Vec<f64> = line.split_whitespace().take(8).map_while(|field| field.parse().ok()).collect();
        let [user, nice, system, idle, iowait, irq, softirq, steal] = times[..] else { return None };
        let cores = machine.lines().skip(1).take_while(|line| line.starts_with("cpu")).count();
        let busy = user + nice + system + irq + softirq + steal;
        // The program's name, in parentheses, may contain spaces. utime, stime, cutime and cstime are fields 14 to 17.
        let (_, fields) = own.rsplit_once(')')?;
        let own: Vec<f64> = fields.split_whitespace().skip(11).take(4).map_while(|field| field.parse().ok()).collect();
        (own.len() == 4 && cores > 0).then(|| Self {
            busy,
            own: own.iter().sum(),
            elapsed: (busy + idle + iowait) / cores as f64,
        })
    }

    /// Cores that other programs used on average since then.
    fn others(&self, after: &Self) -> Option<f64> {
        let elapsed = after.elapsed - self.elapsed;
        (elapsed > 0.0).then(|| ((after.busy - self.busy) - (after.own - self.own)) / elapsed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_others_use_is_all_but_our_own() {
        let own = |ticks: u32| format!("7 (a b) c) S 1 1 1 0 -1 0 0 0 0 0 {ticks} 10 20 30 20 0");
        let machine = |busy: u32, idle: u32| format!("cpu  {busy} 0 0 {idle} 0 0 0 0 0 0\ncpu0 1\ncpu1 1\nintr 5\n");
        let before = Ticks::of(&machine(1000, 5000), &own(100)).expect("ticks");
        assert_eq!(before, Ticks { busy: 1000.0, own: 160.0, elapsed: 3000.0 });
        // 200 ticks later: 150 of the 250 busy ones are ours.
        let after = Ticks::of(&machine(1250, 5150), &own(250)).expect("ticks");
        assert_eq!(before.others(&after), Some(0.5));
        assert_eq!((before.others(&before), Ticks::of("cpu  1 2\n", &own(1))), (None, None));
    }

    #[test]
    fn a_taken_machine_is_not_owned_and_a_released_one_is() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(FILE);
        let held = lock(open(&path).expect("a file"), Duration::ZERO).expect("it is free");
        assert!(lock(open(&path).expect("a file"), Duration::from_millis(50)).is_none());
        drop(held);
        assert!(lock(open(&path).expect("a file"), Duration::ZERO).is_some());
    }
}
