"""The addresses that callbacks may be sent to: callers choose URLs, and must not reach what only this server can."""

from dataclasses import dataclass
from ipaddress import IPv4Network, IPv6Network, ip_address, ip_network

Network = IPv4Network | IPv6Network

# What the Internet routes to hosts. `is_global` is false for most of the rest, but which depends on Python's release:
# 3.11 takes multicast, documentation and every IPv6 address outside 2000::/3 for global.
_UNICAST = (ip_network("0.0.0.0/0"), ip_network("2000::/3"))
_NO_HOSTS: tuple[Network, ...] = (
    ip_network("192.0.0.0/24"),  # protocol assignments
    ip_network("192.88.99.0/24"),  # relays of 6to4
    ip_network("224.0.0.0/4"),  # multicast
    ip_network("2001::/23"),  # protocol assignments, among them Teredo
    ip_network("2002::/16"),  # 6to4: an IPv4 address inside, perhaps a private one
    ip_network("3fff::/20"),  # documentation
)


@dataclass(frozen=True)
class AllowedAddresses:
    """Public addresses, and those of some networks besides.

    IPv6 addresses that stand for an IPv4 address (::ffff:0:0/96, 64:ff9b::/96, 2002::/16) are not public: a gateway
    may translate them to a private one.

    Attributes
    ----------
    networks
        Networks that are allowed though they are not public.

    """

    networks: tuple[Network, ...] = ()

    @classmethod
    def of(cls, text: str) -> "AllowedAddresses":
        """Return the addresses that a setting allows: networks with commas between, such as `10.0.0.0/8`.

        Raises
        ------
        ValueError
            If one is no network.

        """
        return cls(tuple(ip_network(part.strip()) for part in text.split(",") if part.strip()))

    def has(self, text: str) -> bool:
        """Return whether an address is allowed.

        >>> own = AllowedAddresses.of("10.0.0.0/8, ::1/128")
        >>> [own.has(one) for one in ("1.1.1.1", "10.1.2.3", "::1", "192.168.0.1", "::ffff:10.1.2.3")]
        [True, True, True, False, False]
        """
        address = ip_address(text)
        if any(address in network for network in self.networks):
            return True
        public = address.is_global and any(address in network for network in _UNICAST)
        return public and not any(address in network for network in _NO_HOSTS)
