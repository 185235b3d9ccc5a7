from . import flow as flow
