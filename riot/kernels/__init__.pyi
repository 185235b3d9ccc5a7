from . import warm as warm
