from . import slurm_jobs as slurm_jobs
from .executor import Bundle as Bundle
from .executor import Executor as Executor
from .opening import open_cluster as open_cluster
from .sync import SyncExecutor as SyncExecutor
