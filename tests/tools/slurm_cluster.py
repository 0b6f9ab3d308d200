# SPDX-License-Identifier: Apache-2.0
"""A Slurm of one node in a folder, on loopback and free ports, with munge; nothing of the system is used or changed."""
import ctypes
import os
import shutil
import signal
import socket
import subprocess
import sys
import time

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel")
PATHS = "/usr/sbin:/usr/local/sbin"
CONFIGURATION = """\
ClusterName=panelcal
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort={controller_port}
SlurmdPort={node_port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=5
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=batch_sched_delay=0,sched_interval=1,bf_interval=1
SlurmdParameters=config_overrides
MpiDefault=none
ReturnToService=2
KillWait=1
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
NodeName=localhost NodeAddr=127.0.0.1 CPUs={cpus}
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def end_with_parent():
    """Linux: a test that is killed leaves no server behind."""
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


def missing_programs():
    os.environ["PATH"] += os.pathsep + PATHS
    return [name for name in PROGRAMS if not shutil.which(name)]


def enter_named_host():
    """Slurm resolves the name of the host, which not every container can: the process begins anew with another one."""
    if socket.gethostname() == "localhost" or os.geteuid() != 0:
        return
    probe = subprocess.run(["unshare", "--uts", "hostname", "localhost"], capture_output=True, check=False)
    if probe.returncode == 0:
        os.execvp("unshare", ["unshare", "--uts", "sh", "-c", 'hostname localhost && exec "$@"', "sh", sys.executable,
                              *sys.argv])


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def wait_until(true, what, seconds=300):
    """Returns what `true` returns at last."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        found = true()
        if found:
            return found
        time.sleep(0.05)
    raise AssertionError(f"{what}: not within {seconds} s")


class Cluster:
    def __init__(self, folder, cpus):
        self.folder = folder
        self.running = []
        for name in ("state", "spool"):
            (folder / name).mkdir()
        user = subprocess.run(["id", "-un"], capture_output=True, text=True, check=True).stdout.strip()
        (folder / "slurm.conf").write_text(CONFIGURATION.format(
            folder=folder, user=user, cpus=cpus, controller_port=free_port(), node_port=free_port()))
        key = folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o600)
        os.environ["SLURM_CONF"] = str(folder / "slurm.conf")
        try:
            self.start("munged", "--force", "--foreground", f"--key-file={key}", f"--socket={folder}/munge.socket",
                       f"--pid-file={folder}/munged.pid", f"--log-file={folder}/munged.log",
                       f"--seed-file={folder}/munged.seed")
            wait_until((folder / "munge.socket").exists, "munged listens")
            self.start("slurmctld", "-D", "-i", "-f", folder / "slurm.conf")
            self.start("slurmd", "-D", "-N", "localhost", "-f", folder / "slurm.conf")
            wait_until(lambda: self.node_state() == "idle", "the node is idle")
        except BaseException:
            self.stop()
            raise

    def start(self, *words):
        log = open(self.folder / f"{words[0]}.output", "w")
        self.running.append(subprocess.Popen([*map(str, words)], stdout=log, stderr=log, stdin=subprocess.DEVNULL,
                                             preexec_fn=end_with_parent))
        log.close()

    def call(self, *words):
        done = subprocess.run([*map(str, words)], capture_output=True, text=True, check=False)
        return done.stdout.strip() if done.returncode == 0 else ""

    def node_state(self):
        return self.call("sinfo", "--noheader", "--format=%t")

    def queue(self):
        """The state of each task."""
        return self.call("squeue", "--noheader", "--array", "--format=%t").split()

    def stop(self):
        self.call("scancel", "--user", os.environ.get("USER", "root"))
        for child in reversed(self.running):
            child.send_signal(signal.SIGTERM)
        for child in reversed(self.running):
            try:
                child.wait(20)
            except subprocess.TimeoutExpired:
                child.kill()
                child.wait()
        self.running = []
